"""
Tell objects by on-off switches
===============================

Twenty-two switches of a hand, ten grasps an object: hyperplanes, a sign table, a minimized circuit, and Verilog.
"""

import tempfile

import matplotlib.pyplot as plt
import numpy as np

from varishold.circuit import circuit_size
from varishold.circuit.writers import export
from varishold.grasp import HyperplaneClassifier

# %%
# Three objects close their own switches; one switch in twenty reads wrongly.
rng = np.random.default_rng(4)
typical = rng.integers(0, 2, (3, 22))
truth = np.repeat(["bottle", "box", "mug"], 10)
grasps = typical[np.repeat([0, 1, 2], 10)] ^ (rng.random((30, 22)) < 0.05)
classifier = HyperplaneClassifier().fit(grasps, truth)

# %%
# An answer says what decided, and how many switches may fail before it changes: that number is proved.
new = typical ^ (rng.random((3, 22)) < 0.05)
for grasp in new:
    print(classifier.explain(grasp))

# %%
# The same decision as a circuit, for an FPGA or a controller.
print(circuit_size(classifier.netlist_))
with tempfile.TemporaryDirectory() as folder:
    for path in export(classifier.netlist_, "verilog", folder):
        print(f"{path.name}: {len(path.read_text('utf-8').splitlines())} lines")

figure, axes = plt.subplots(figsize=(7, 3))
axes.imshow(grasps, aspect="auto", cmap="Greys")
axes.set_xlabel("switch")
axes.set_ylabel("grasp")
axes.set_yticks([4, 14, 24], ["bottle", "box", "mug"])
plt.show()
