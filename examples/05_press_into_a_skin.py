"""
Pressure is not shape
=====================

A flat face that is pressed into an elastic skin presses hardest along its rim. Who knows the skin sees through it.
"""

import matplotlib.pyplot as plt
import numpy as np

from varishold.skin import Skin, press, reconstruct, sense
from varishold.solids import Cylinder, Pose
from varishold.touch import find_contacts, recognize

SHAPE, PITCH_M = (32, 32), 1e-3
rubber = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=0.5e-3, youngs_modulus_pa=150e3)

# %%
# A flat punch, 14 mm across, pressed in by .6 mm; the taxels lie in the skin and their noise is 1 %.
pressed = press(Cylinder(14e-3, 8e-3), rubber, depth=0.6e-3, pose=Pose(), shape=SHAPE, pitch_m=PITCH_M)
stress = sense(pressed)
stress += np.random.default_rng(0).normal(0, 0.01 * stress.max(), SHAPE)
print(f"the rim feels {stress.max() / stress[14:18, 14:18].mean():.2f} times what the middle feels")

# %%
# Without the skin, all kinds of skin are weighed together. With it, the surface is reconstructed first.
(contact,) = find_contacts(stress, pitch=PITCH_M)
print("skin unknown:", recognize(contact).name)
relief = reconstruct(stress, rubber, pitch=PITCH_M)
(seen,) = find_contacts(relief.height, pitch=relief.pitch_m)
surface = recognize(seen)
print(f"seen through it: {surface.name}, p = {surface.probability:.2f}, {1e3 * surface.size[0]:.1f} mm across")

figure, axes = plt.subplots(1, 3, figsize=(10, 3))
axes[0].imshow(stress, cmap="magma")
axes[0].set_title("what the taxels feel")
axes[1].imshow(relief.height, cmap="magma")
axes[1].set_title("the surface behind it")
for label, values in {"felt": stress, "seen": relief.height}.items():
    cut = values[len(values) // 2]
    axes[2].plot(np.linspace(-16, 16, len(cut)), cut / cut.max(), label=label)
axes[2].set_xlabel("x (mm)")
axes[2].legend()
plt.show()
