"""
Name what presses on a pad
==========================

A recording is read, the contacts of one frame are found, and each is named, with its probability and the reasons.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import varishold
from varishold.levelset import outlines

HERE = Path(__file__).parent if "__file__" in globals() else Path()

# %%
# Every surface pressed once into a soft skin over 32 x 32 taxels, three of them dead.
recording = varishold.read(HERE / "surfaces.npz")
pad = recording.pads["pad"]
frame = pad.frames[np.argmax(pad.frames[:40].sum((1, 2)))]

# %%
# A contact is a part of the frame that stands out of the noise. Its name comes with all others that it may be.
(contact,) = varishold.find_contacts(frame, pitch=pad.pitch_m, valid=pad.valid)
surface = varishold.recognize(contact)
print(f"{surface.name}, p = {surface.probability:.2f}, {1e3 * surface.size[0]:.1f} mm across")
print("90 % of the probability:", ", ".join(surface.answer_set))
for reason in surface.reasons:
    print("-", reason)

# %%
# The outlines at falling thresholds are what the name rests on.
figure, axes = plt.subplots(figsize=(5, 4))
axes.imshow(frame, cmap="Greys", extent=(-16, 16, 16, -16))
for level in np.linspace(0.9, 0.1, 9) * frame.max():
    for outline in outlines(frame, level):
        axes.plot(*outline.T, color=plt.get_cmap("plasma")(level / frame.max()))
axes.set_title(f"{surface.name}, p = {surface.probability:.2f}")
plt.show()
