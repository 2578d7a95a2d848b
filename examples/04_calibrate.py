"""
Calibrate by pressing anything
==============================

Fifty to a hundred presses of anything, nobody says of what, tell how unequal the taxels are.
"""

import matplotlib.pyplot as plt
import numpy as np

from varishold.calibration import calibrate_unlabelled
from varishold.recording import Pad, Recording
from varishold.solids import draw_contact, ideal_frame

SHAPE, PRESSES = (16, 16), 80
rng = np.random.default_rng(7)
gains = np.exp(rng.normal(0, 0.2, SHAPE))

# %%
# Presses of drawn things, anywhere; between them the pad is free, so that its rest and noise show.
frames = []
for _ in range(PRESSES):
    drawn = draw_contact(
        rng, str(rng.choice(["sphere", "cylinder", "square-pillar"])), field_m=(16.0, 16.0), size_m=(7.0, 11.0)
    )
    pressed = gains * ideal_frame(drawn.solid, SHAPE, 1.0, pose=drawn.pose)
    frames += [np.zeros(SHAPE)] * 3 + [share * 200 / pressed.max() * pressed for share in (0.5, 1.0, 0.5)]
readings = np.round(np.array(frames) + rng.normal(0, 1, (len(frames), *SHAPE)))
recording = Recording({"pad": Pad(readings)}, time_s=np.arange(len(frames)) / 20)

# %%
# The calibration says what it found, how sure it is of that, and what could not be known.
calibration = calibrate_unlabelled([recording])
for finding in calibration.findings:
    print(finding)
found = calibration.sensor.gains
before, after = np.std(np.log(gains)), np.std(np.log(gains) - np.log(found))
print(f"unequal by {before:.1%} before, {after:.1%} after")

figure, axes = plt.subplots(1, 2, figsize=(7, 3.2))
for panel, (title, values) in zip(axes, {"true gains": gains, "found": found}.items(), strict=True):
    panel.imshow(values / np.median(values), vmin=0.5, vmax=1.6)
    panel.set_title(title)
    panel.axis("off")
plt.show()
