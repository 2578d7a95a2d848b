"""What touch answers about one contact of a recording."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from varishold._cached import cached_property
from varishold.touch.surface import Sides, Surface
from varishold.touch.top import rest_reach, top_height

__all__ = ["Answer"]

# Fitted radii are off by .047 of them in 90 % of drawn presses; half as much again is for skins that are not quite
# what they are said to be.
_FITTED_RADIUS = 0.07
# Taxels that a leaning face takes.
_FEWEST_LEANING = 9
# So far down from the top a ball's section is neither widened by a gel's skirt nor small.
_ABOVE_SKIRT = 0.7
# A skirt widens the lowest section by more than so many taxels beyond its interval: so far taxels and noise go. What is
# told from above it was off by up to that share of drawn ones.
_WIDENED, _TOLD_ABOVE = 0.3, 0.05
# At a bar's ends a skirt is at most so many times as long as it falls off between the two sections.
_AT_ENDS = 2.5
# Forms that grow down from a point or a line, by breadths that go as the height or as a circle's chords.
_STRAIGHT, _CURVED = ("cone", "pyramid", "ridge", "hip"), ("sphere", "lying cylinder")


@dataclass(frozen=True)
class Answer:
    """One contact of a recording, recognized.

    Parameters
    ----------
    file : str or None
        Where the recording came from.
    frame : int
        Zero-based frame; of a press, the frame of largest total.
    time_s : float or None
        The frame's time.
    pad : str
        Name of the pad.
    contact : int
        Number of the contact in its frame, 0 the largest.
    surface : Surface
        What it is.
    unit : str
        Unit of the taxels, ``"raw"`` where unknown.
    pascals_per_unit : float or None
        What one unit is in pascal, where it is a pressure.
    pitch_m : (float, float) or None
        Row and column spacing.
    sensor : str or None
        The sensor file that was used, or the sensor's name.
    frame_notes : tuple of str
        What was done to the frame before contacts were looked for.
    """

    file: str | None
    frame: int
    time_s: float | None
    pad: str
    contact: int
    surface: Surface
    unit: str
    pascals_per_unit: float | None
    pitch_m: tuple[float, float] | None
    sensor: str | None = None
    frame_notes: tuple[str, ...] = ()

    @property
    def force_n(self) -> float | None:
        """Force of the contact in newtons, where the unit is a pressure and the pitch is known."""
        if self.pascals_per_unit is None or self.pitch_m is None:
            return None
        contact = self.surface.contact
        felt = contact.values[contact.mask] + contact.state.beneath
        return float(felt.sum()) * contact.taxel_area * self.pascals_per_unit

    @property
    def depth_m(self) -> float | None:
        """Height of the form's top above the rest, metres: of a height map, or of a fit in pascal."""
        if self._is_height_map:
            return top_height(self.surface)[0]
        return getattr(self.surface, "depth_m", None)

    @property
    def size(self) -> tuple[float, float]:
        """Lengths (long, short) as the surface's, on a height map without what taxels average away or a skirt adds."""
        return self._skirt[0] if self._skirt is not None else self._lowest_size

    @property
    def _lowest_size(self) -> tuple[float, float]:
        return self.surface.size_of(height_map=self._is_height_map)

    @cached_property
    def _lowest_interval(self) -> Sides:
        """Return the lowest section's intervals, wider as the rest of a height map is uneven and sides slope."""
        surface = self.surface
        long, short = surface.size_interval_of(height_map=self._is_height_map)
        reach = rest_reach(surface.contact) if self._is_height_map else 0.0
        above, threshold = surface.nearest(_ABOVE_SKIRT), surface.profile.threshold
        risen = float(threshold[above] - threshold[surface.lowest])
        if not 0 < reach or not 0 < risen:
            return long, short
        grown = zip(surface.breadths(surface.lowest), surface.breadths(above), strict=True)
        wider = [abs(low - high) * reach / risen for low, high in grown]
        return _widened(long, wider[0]), _widened(short, wider[1])

    @cached_property
    def _skirt(self) -> tuple[tuple[float, float], Sides] | None:
        """Return the lengths on a height map whose lowest section a gel's skirt widens, and their intervals.

        The short side follows the form's law from a section above the skirt; its interval reaches to what the lowest
        tells. How much longer a bar seems at its ends no law tells: there the interval alone gets wider. None where
        both sections tell the same.
        """
        surface = self.surface
        if not self._is_height_map or surface.cut or surface.name not in _STRAIGHT + _CURVED:
            return None
        top, above = top_height(surface)[0], surface.nearest(_ABOVE_SKIRT)
        h, h_above = top - surface.contact.floor, top - float(surface.contact.profile.threshold[above])
        long_above, short_above = surface.breadths(above)
        long, short = self._lowest_size
        if not 0 < h_above < h or short <= 0:
            return None
        told = short_above * h / h_above
        if surface.name in _CURVED:
            told = 2 * math.sqrt(max(2 * _radius_of(h_above, short_above) * h - h * h, 0.0))
        (long_low, long_high), (short_low, short_high) = self._lowest_interval
        taxel = math.sqrt(surface.contact.taxel_area)
        if short - told <= _WIDENED * taxel + 0.5 * (short_high - short_low):
            return None
        sides = (told * (1 - _TOLD_ABOVE), max(short_high, told * (1 + _TOLD_ABOVE)))
        if surface.name not in ("ridge", "hip", "lying cylinder"):
            return (told, told), (sides, sides)
        least = max(min(long_low, long - _AT_ENDS * (long - long_above)), 0.0)
        return (long, told), ((least, long_high), sides)

    @property
    def radius_m(self) -> float | None:
        """Radius of curvature, metres, of a sphere or lying cylinder: on a height map, or fitted at a known depth."""
        surface = self.surface
        if self.pitch_m is None or surface.name not in ("sphere", "lying cylinder"):
            return None
        if not self._is_height_map:
            return getattr(surface, "radius_m", None)
        found = self._curvature
        return None if found is None else found[0]

    @cached_property
    def _curvature(self) -> tuple[float, float] | None:
        """Return the radius on a height map and the factor by which its interval reaches to either side.

        A gel's skirt widens the lowest section: where one higher up tells a radius beyond the interval, that is taken,
        and the interval reaches to the first one.
        """
        surface = self.surface
        top, half = top_height(surface)
        h, b = self._chord(top)
        if h <= 0 or b <= 0:
            return None
        low, high = self._lowest_interval[1]
        off = 1 + math.hypot((high - low) / b, half / h)
        radius = _radius_of(h, b)
        above = surface.nearest(_ABOVE_SKIRT)
        h_above = top - float(surface.contact.profile.threshold[above])
        if surface.cut or h_above <= 0:
            return radius, off
        other = _radius_of(h_above, surface.breadths(above)[1])
        apart = max(radius / other, other / radius)
        return (radius, off) if apart <= off else (other, apart)

    def _chord(self, top: float) -> tuple[float, float]:
        """Return how far below the top a height map's section lies, and its breadth: the one the size belongs to."""
        surface = self.surface
        if surface.cut:
            middle = surface.middle
            return top - float(surface.contact.profile.threshold[middle]), surface.breadths(middle)[1]
        return top - surface.contact.floor, self._lowest_size[1]

    @property
    def _is_height_map(self) -> bool:
        return self.unit in ("m", "metre", "meter")

    @property
    def size_interval(self) -> Sides:
        """Intervals of the surface's long and short side that hold the true ones in 90 %, in the unit of its size."""
        return self._skirt[1] if self._skirt is not None else self._lowest_interval

    @property
    def radius_interval_m(self) -> tuple[float, float] | None:
        """Interval that holds the true radius of curvature in 90 %: it goes as the size squared over the height."""
        radius = self.radius_m
        if radius is None:
            return None
        found = self._curvature if self._is_height_map else None
        off = 1 + _FITTED_RADIUS if found is None else found[1]
        return radius / off, radius * off

    @property
    def depth_interval_m(self) -> tuple[float, float] | None:
        """Interval of the depth that holds the true one in 90 %, of a height map."""
        if not self._is_height_map:
            return None
        height, half = top_height(self.surface)
        return height - half, height + half

    @property
    def tilt_rad(self) -> float | None:
        """How far a flat face leans, from the plane through its upper half, where the frame is a height map."""
        contact = self.surface.contact
        if not self._is_height_map or self.pitch_m is None or self.surface.form not in ("pillar", "plane"):
            return None
        upper = contact.mask & (contact.values > 0.5 * (contact.peak + contact.floor))
        row, col = np.nonzero(upper)
        if len(row) < _FEWEST_LEANING or min(np.ptp(row), np.ptp(col)) < 2:
            return None
        row_m, col_m = contact.spacing
        design = np.column_stack([np.ones(len(row)), col * col_m, row * row_m])
        plane = np.linalg.lstsq(design, contact.values[upper], rcond=None)[0]
        return float(np.arctan(np.hypot(plane[1], plane[2])))

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as plain values that JSON can hold."""
        s, contact = self.surface, self.surface.contact
        known = self.pitch_m is not None
        unit = math.sqrt(contact.taxel_area)
        x, y = s.position
        spacing_y, spacing_x = contact.spacing
        size = list(self.size)
        inequality = s.inequality
        return {
            "file": self.file,
            "frame": self.frame,
            "time_s": self.time_s,
            "pad": self.pad,
            "contact": self.contact,
            "name": s.name,
            "form": s.form,
            "section": s.section,
            "probability": _rounded(s.probability),
            "alternatives": {name: _rounded(p) for name, p in s.alternatives.items()},
            "outline": s.outline,
            "outline_probability": _rounded(s.outline_probability),
            "answer_set": list(s.answer_set),
            "cut": list(s.cut),
            "reasons": list(s.reasons),
            "position_m": [x, y] if known else None,
            "orientation_rad": s.orientation,
            "size_m": size if known else None,
            "size_interval_m": [list(side) for side in self.size_interval] if known and s.has_size else None,
            "radius_m": self.radius_m,
            "radius_interval_m": _listed(self.radius_interval_m),
            "area_m2": s.area if known else None,
            "position_taxels": [x / spacing_x, y / spacing_y],
            "size_taxels": [length / unit for length in size],
            "area_taxels": s.area / contact.taxel_area,
            "apex_exponent": s.exponent,
            "defect_sqrt_area": _finite(inequality.defect_sqrt_area),
            "defect_perimeter": _finite(inequality.defect_perimeter),
            "bulge_sqrt_area": _finite(inequality.bulge_sqrt_area),
            "bulge_perimeter": _finite(inequality.bulge_perimeter),
            "holes": s.holes,
            "force_n": self.force_n,
            "depth_m": self.depth_m,
            "depth_interval_m": _listed(self.depth_interval_m),
            "tilt_rad": self.tilt_rad,
            "rounding_m": None,
            "sensor": self.sensor,
            "frame_notes": list(self.frame_notes),
        }


def _widened(interval: tuple[float, float], by: float) -> tuple[float, float]:
    """Return an interval that holds as often what is off by so much beside."""
    middle, half = (interval[0] + interval[1]) / 2, (interval[1] - interval[0]) / 2
    half = math.hypot(half, by)
    return max(middle - half, 0.0), middle + half


def _radius_of(depth: float, breadth: float) -> float:
    """Return the radius of the circle that a chord of that breadth cuts so far below its top."""
    return (breadth * breadth / 4 + depth * depth) / (2 * depth)


def _listed(interval: tuple[float, float] | None) -> list[float] | None:
    return None if interval is None else list(interval)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _rounded(p: float) -> float:
    return round(p, 4)
