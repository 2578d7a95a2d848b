"""
Let the threshold fall
======================

How a falling threshold sees a form: the sections of a pillar have one size, those of a cone grow evenly, those of a
ball grow fast at first. Only the way they grow counts, not how hard one presses.
"""

import matplotlib.pyplot as plt
import numpy as np

from varishold.levelset import find_contacts, outlines
from varishold.solids import Cone, Cylinder, LyingCylinder, SquarePillar, ideal_frame

SOLIDS = {
    "cylinder": Cylinder(14.0, 8.0),
    "square pillar": SquarePillar(12.0, 8.0),
    "cone": Cone(20.0, 8.0),
    "lying cylinder": LyingCylinder(22.0, 14.0),
}

# %%
# An ideal array reads how far each taxel is pressed in. Each frame is cut at 32 thresholds.
figure, axes = plt.subplots(2, len(SOLIDS), figsize=(11, 5), height_ratios=(3, 2), sharey="row")
for (name, solid), (above, below) in zip(SOLIDS.items(), axes.T, strict=True):
    frame = ideal_frame(solid, (32, 32), 1.0)
    (contact,) = find_contacts(frame, 32, pitch=1.0)
    above.imshow(frame, cmap="Greys", extent=(-16, 16, 16, -16))
    for share in np.linspace(0.95, 0.05, 10):
        for outline in outlines(frame, share * frame.max()):
            above.plot(*outline.T, color=plt.get_cmap("plasma")(share))
    above.set_title(name)
    above.axis("off")

    # The area of each section, from the top down: flat, a parabola, a straight line ...
    profile = contact.profile
    below.plot(1 - profile.threshold / frame.max(), profile.area / np.nanmax(profile.area))
    below.set_xlabel("fallen by")
    below.set_ylim(0, 1.05)
    print(f"{name}: {profile.area[len(profile) // 2] / np.nanmax(profile.area):.2f} of the area at half height")
axes[1, 0].set_ylabel("area of the section")
plt.show()
