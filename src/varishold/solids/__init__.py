"""The solids: each one's face as a height map, its size and its name; one file a solid.

`SOLIDS` is the registry, by the name that commands use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "SOLIDS",
    "Assembly",
    "Box",
    "Chance",
    "Cone",
    "ConeFrustum",
    "Cylinder",
    "Drawn",
    "Edge",
    "Ellipsoid",
    "HalfCylinder",
    "HexagonalPrism",
    "Hip",
    "LBlock",
    "Laid",
    "Lump",
    "LyingCylinder",
    "MeshSolid",
    "Part",
    "Plane",
    "Pose",
    "Pyramid",
    "PyramidFrustum",
    "Raised",
    "RectangularPillar",
    "Ridge",
    "Solid",
    "Sphere",
    "SquarePillar",
    "Torus",
    "TriangularPrism",
    "Variant",
    "Wedge",
    "draw_contact",
    "ideal_frame",
    "lay_down",
    "pad_points",
    "regular_polygon",
    "solid_of_size",
]

if TYPE_CHECKING:
    from varishold.solids.assembly import Assembly
    from varishold.solids.body import Part, regular_polygon
    from varishold.solids.box import Box
    from varishold.solids.chance import Chance
    from varishold.solids.cone import Cone
    from varishold.solids.cone_frustum import ConeFrustum
    from varishold.solids.cylinder import Cylinder
    from varishold.solids.draw import draw_contact
    from varishold.solids.edge import Edge
    from varishold.solids.ellipsoid import Ellipsoid
    from varishold.solids.half_cylinder import HalfCylinder
    from varishold.solids.hexagonal_prism import HexagonalPrism
    from varishold.solids.hip import Hip
    from varishold.solids.ideal import ideal_frame, pad_points
    from varishold.solids.l_block import LBlock
    from varishold.solids.laid import Laid, lay_down
    from varishold.solids.lump import Lump
    from varishold.solids.lying_cylinder import LyingCylinder
    from varishold.solids.mesh_solid import MeshSolid
    from varishold.solids.plane import Plane
    from varishold.solids.pyramid import Pyramid
    from varishold.solids.pyramid_frustum import PyramidFrustum
    from varishold.solids.raised import Raised
    from varishold.solids.rectangular_pillar import RectangularPillar
    from varishold.solids.registry import SOLIDS, solid_of_size
    from varishold.solids.ridge import Ridge
    from varishold.solids.solid import Drawn, Pose, Solid
    from varishold.solids.sphere import Sphere
    from varishold.solids.square_pillar import SquarePillar
    from varishold.solids.torus import Torus
    from varishold.solids.triangular_prism import TriangularPrism
    from varishold.solids.variant import Variant
    from varishold.solids.wedge import Wedge
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
