"""
Say what your sensor does
=========================

A sensor bends, scales and clips what presses on it. What you know of that, a sensor file says, and it is undone before
anything is named.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from varishold.sensor import Logarithmic, Sensor, read_sensor, write_sensor
from varishold.solids import Cone, ideal_frame
from varishold.touch import find_contacts, recognize

# %%
# A mat of 24 x 24 taxels, 2 mm apart: a logarithmic response, unequal gains, a rest of 40 counts.
rng = np.random.default_rng(3)
mat = Sensor(
    name="a mat", shape=(24, 24), pitch_m=(2e-3, 2e-3), rest=40.0, span=215.0, full_scale=1.0,
    response=Logarithmic(5.0), gains=np.exp(rng.normal(0, 0.12, (24, 24))),
)  # fmt: skip
cone = ideal_frame(Cone(18.0, 0.9), (24, 24), 1.0)
readings = np.round(mat.forward(cone) + rng.normal(0, 1, cone.shape))

# %%
# What it reads is no cone any more. Once the sensor is known, it is one again.
raw = recognize(find_contacts(readings - 40)[0])
known = recognize(find_contacts(readings, sensor=mat)[0])
print(f"as it came: {raw.name}, p = {raw.probability:.2f}; with its sensor: {known.name}, p = {known.probability:.2f}")

# %%
# The description is a file that stands beside the recordings: ``varishold touch`` finds it there.
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder, "sensor.toml")
    write_sensor(mat, path)
    print(path.read_text("utf-8"))
    undone = read_sensor(path).undo(readings).frame

figure, axes = plt.subplots(1, 3, figsize=(9, 3))
for panel, (title, frame) in zip(
    axes, {"what presses": cone, "what it reads": readings, "undone": undone}.items(), strict=True
):
    panel.imshow(frame)
    panel.set_title(title)
    panel.axis("off")
plt.show()
