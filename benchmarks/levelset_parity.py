"""Exactness of sections: largest differences from contourpy, and areas of analytic surfaces.

python -m benchmarks.levelset_parity
"""

from __future__ import annotations

import itertools

import contourpy
import numpy as np

from benchmarks._figures import figure
from varishold.levelset.contacts import find_contacts

SEED = 5
FRAMES = 200


def polygon_moments(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the integrals of 1, x, y, x^2, x y and y^2 over a closed polygon."""
    x0, x1, y0, y1 = x[:-1], x[1:], y[:-1], y[1:]
    cross = x0 * y1 - x1 * y0
    return np.array(
        [
            cross.sum() / 2,
            ((x0 + x1) * cross).sum() / 6,
            ((y0 + y1) * cross).sum() / 6,
            ((x0 * x0 + x0 * x1 + x1 * x1) * cross).sum() / 12,
            ((x0 * y1 + 2 * x0 * y0 + 2 * x1 * y1 + x1 * y0) * cross).sum() / 24,
            ((y0 * y0 + y0 * y1 + y1 * y1) * cross).sum() / 12,
        ]
    )


def main() -> None:
    rng = np.random.default_rng(SEED)
    area = perimeter = position = spread = 0.0
    compared = 0
    for _ in range(FRAMES):
        rows, cols = rng.integers(8, 40, 2)
        y, x = np.mgrid[0:rows, 0:cols]
        cy, cx, radius = rng.uniform(0, rows), rng.uniform(0, cols), rng.uniform(3, 12)
        frame = np.maximum(1 - (np.hypot(x - cx, y - cy) / radius) ** rng.choice([1, 2, 4]), 0)
        frame += rng.normal(0, 0.01, frame.shape)
        # Above half of the peak no contact can be split.
        floor = 0.51 * float(frame.max())
        contacts = find_contacts(frame, 16, floor=floor)
        if len(contacts) != 1:
            continue
        profile = contacts[0].profile
        origin = np.array(contacts[0].peak_position)
        generator = contourpy.contour_generator(
            np.r_[-0.5, np.arange(cols), cols - 0.5] - (cols - 1) / 2 - origin[0],
            np.r_[-0.5, np.arange(rows), rows - 0.5] - (rows - 1) / 2 - origin[1],
            np.pad(frame, 1, mode="edge"),
            name="serial",
            fill_type="OuterOffset",
            line_type="Separate",
        )
        for i, level in enumerate(profile.threshold):
            total = np.zeros(6)
            for points, offsets in zip(*generator.filled(level, np.inf), strict=True):
                for a, b in itertools.pairwise(offsets):
                    total += polygon_moments(points[a:b, 0], points[a:b, 1])
            length = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in generator.lines(level))
            m, mx, my = total[0], total[1] / total[0], total[2] / total[0]
            xx, xy, yy = total[3] / m - mx * mx, total[4] / m - mx * my, total[5] / m - my * my
            covariance = np.array([[xx, xy], [xy, yy]])
            area = max(area, abs(profile.area[i] / m - 1))
            perimeter = max(perimeter, abs(profile.perimeter[i] / length - 1)) if length else perimeter
            position = max(position, float(np.hypot(*(profile.centroid[i] - origin - (mx, my)))))
            spread = max(spread, abs(profile.covariance[i] - covariance).max() / np.trace(covariance))
            compared += 1
    print(f"{compared} sections of {FRAMES} frames with 1 % noise against contourpy, largest differences:")
    for name, worst, unit in (
        ("area", area, ""),
        ("perimeter", perimeter, ""),
        ("centroid", position, "taxel"),
        ("second moments, of their trace", spread, ""),
    ):
        print(f"    {name} {figure(name, worst, '.0e', unit, bar='<= 1e-9')}")
    y, x = np.mgrid[-20:21, -20:21] + np.array([0.3, -0.2])[:, None, None]
    surfaces = {
        "paraboloid, -pi/3": (16 - (x**2 + y**2) / 16, lambda depth: 16 * np.pi * depth),
        "cone, about -.65": (16 - np.hypot(x, y), lambda depth: np.pi * depth**2),
        "pyramid": (16 - np.maximum(abs(x), abs(y)), lambda depth: 4 * depth**2),
    }
    for name, (surface, exact) in surfaces.items():
        (contact,) = find_contacts(np.maximum(surface, 0), 60, floor=1.0)
        want = exact(16 - contact.profile.threshold)
        bias = (contact.profile.area - want)[want > 12]
        of = f"area less the analytic one, {name}"
        print(f"{of}: {figure(of, bias.mean(), '.2f', 'taxel')} on the mean of {bias.size} levels")


if __name__ == "__main__":
    main()
