"""The answer of touch: what a surface is called, how sure that is, its measures and the reasons."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass, replace
from operator import neg

import numpy as np
from numpy.typing import NDArray

from varishold._cached import cached_property
from varishold.errors import InputError
from varishold.levelset.contact import Contact
from varishold.levelset.profile import Profile
from varishold.levelset.second_moments import principal_angle, principal_moments
from varishold.touch.chords import Inequality, inequality
from varishold.touch.cut import Side, completed_circle, cut_sides
from varishold.touch.decision import Parameters
from varishold.touch.exponent import apex_exponent
from varishold.touch.names import KINDS, NAMES, OUTLINE_OF, OUTLINES, Form, Outline, Section
from varishold.touch.reasons import reasons_for
from varishold.touch.scale import averaging, on_scale

__all__ = ["Surface"]

_NAME_OF = np.array([[kind.name == name for kind in KINDS] for name in NAMES], dtype=np.float64)
_SQUARE_TURN = math.pi / 2
#: (low, high) of the long side, (low, high) of the short one.
Sides = tuple[tuple[float, float], tuple[float, float]]
# What an answer set holds.
_HELD = 0.9


@dataclass(frozen=True)
class Surface:
    """What touch says of one contact.

    Lengths are in metres where the contact's pitch is known, in taxels otherwise; positions are (x, y) from
    the pad's centre.

    Parameters
    ----------
    contact : Contact
        The contact that was recognized.
    name : str
        Its most probable name, one of `varishold.touch.NAMES`.
    form, section : str
        The paper's form and the outline of its sections, of the most probable kind that has this name.
    probability : float
        P(name).
    kind_probability : ndarray of shape (n_kinds,), float64
        Probability of each of `varishold.touch.KINDS`; sums to 1.
    inputs : ndarray of shape (n_inputs,), float64
        The whitened numbers that decided.
    parameters : Parameters
        The learned table that weighed them.
    """

    contact: Contact
    name: str
    form: Form
    section: Section
    probability: float
    kind_probability: NDArray[np.float64]
    inputs: NDArray[np.float64]
    parameters: Parameters

    def __repr__(self) -> str:
        return f"Surface({self.name!r}, probability={self.probability:.2f}, {self.contact!r})"

    @cached_property
    def profile(self) -> Profile:
        """The contact's sections, measured."""
        return self.contact.profile

    @cached_property
    def names(self) -> dict[str, float]:
        """Probability of every name, most probable first; sums to 1."""
        p = _NAME_OF @ self.kind_probability
        return {NAMES[i]: float(p[i]) for i in np.argsort(-p, kind="stable")}

    @property
    def alternatives(self) -> dict[str, float]:
        """Probability of every other name that has at least .01, most probable first."""
        return {name: p for name, p in self.names.items() if name != self.name and p >= 0.01}

    @cached_property
    def outlines(self) -> dict[Outline, float]:
        """Probability of every outline, most probable first; sums to 1."""
        p = dict.fromkeys(OUTLINES, 0.0)
        for name, share in self.names.items():
            p[OUTLINE_OF[name]] += share
        return dict(sorted(p.items(), key=lambda item: -item[1]))

    @property
    def outline(self) -> Outline:
        """The most probable outline: what can be told even where the profile cannot."""
        return next(iter(self.outlines))

    @property
    def outline_probability(self) -> float:
        """P(outline)."""
        return self.outlines[self.outline]

    @cached_property
    def answer_set(self) -> tuple[str, ...]:
        """The fewest names that together hold 90 %, most probable first."""
        held, total = [], 0.0
        for name, share in self.names.items():
            held.append(name)
            total += share
            if total >= _HELD:
                break
        return tuple(held)

    @cached_property
    def cut(self) -> tuple[Side, ...]:
        """The sides (left, right, top, bottom) at which the pad ends the contact."""
        return cut_sides(self.contact)

    @cached_property
    def reasons(self) -> tuple[str, ...]:
        """Sentences that tell what was measured and what decided, for a person to read."""
        return reasons_for(self)

    @cached_property
    def inequality(self) -> Inequality:
        """Defects and bulges of sqrt(area) and perimeter against their chords (eq. [18], corrected)."""
        contact = self.contact
        return inequality(self.profile, taxel_area=contact.taxel_area, sigma=contact.sigma)

    @cached_property
    def exponent(self) -> float | None:
        """Apex exponent k of A ~ (theta_1 - theta)^k, or None where too few sections are usable."""
        c = self.contact
        return apex_exponent(
            self.profile.threshold, self.profile.area, peak=c.peak, floor=c.floor, taxel_area=c.taxel_area
        )

    @cached_property
    def areas(self) -> list[float]:
        """Area of every section, as in the profile: of so few numbers a list is quicker than an array."""
        areas: list[float] = self.profile.area.tolist()
        return areas

    @cached_property
    def lowest(self) -> int:
        """Index of the lowest section that is not empty.

        Raises
        ------
        InputError
            If all are, because the levels that were given lie above the contact.
        """
        for i in reversed(range(len(self.areas))):
            if self.areas[i] > 0:
                return i
        raise InputError(f"all levels lie above the contact's peak, {self.contact.peak:g}: nothing of it was measured")

    def nearest(self, share: float) -> int:
        """Return the index of the section, not empty, nearest that share of the way from the top to the floor."""
        contact, threshold, first = self.contact, self._thresholds, self._highest
        wanted = contact.peak - share * (contact.peak - contact.floor)
        below = bisect_left(threshold, -wanted, first, self.lowest, key=neg)
        return below - (below > first and threshold[below - 1] - wanted <= wanted - threshold[below])

    @cached_property
    def _thresholds(self) -> list[float]:
        threshold: list[float] = self.profile.threshold.tolist()
        return threshold

    @cached_property
    def _highest(self) -> int:
        """Index of the highest section that is not empty."""
        return next(i for i, area in enumerate(self.areas) if area > 0)

    @cached_property
    def completed(self) -> tuple[float, float, float] | None:
        """The whole circle (x, y, diameter) of a round contact that the pad cuts; None where there is none."""
        if self.section != "circle" or not self.cut or self.form not in ("pillar", "spherical", "pyramidal"):
            return None
        return completed_circle(self.contact, self.middle if self.form == "pillar" else self.lowest, self.cut)

    @property
    def position(self) -> tuple[float, float]:
        """Centroid (x, y) of the lowest section; of a circle that the pad cuts, its middle, even beyond the pad."""
        if self.completed is not None:
            return self.completed[:2]
        x, y = self.profile.centroid[self.lowest]
        return float(x), float(y)

    @property
    def area(self) -> float:
        """Area of the lowest section."""
        return self.areas[self.lowest]

    @property
    def holes(self) -> int:
        """Holes in the section at half height."""
        profile = self.profile
        middle = 0.5 * (self.contact.peak + self.contact.floor)
        return int(profile.holes[np.argmin(np.abs(profile.threshold - middle))])

    @cached_property
    def size(self) -> tuple[float, float]:
        """Lengths (long, short) of the lowest section; of a pillar or frustum, of its top face; whole if cut."""
        if self.completed is not None:
            return self.completed[2], self.completed[2]
        sized, scale = self._on_scale
        area, covariance = sized._sized_section()
        long, short = _sides(self.section, area, covariance)
        return scale * long, scale * short

    @cached_property
    def _on_scale(self) -> tuple[Surface, float]:
        """This surface where its sizes are measured, and by what its lengths are to be multiplied.

        How far sizes are off was learned from contacts of so many taxels; of a larger one neighbours are averaged.
        """
        factor = averaging(self.contact)
        if factor == 1:
            return self, 1.0
        contact = on_scale(self.contact)
        if contact is self.contact:
            return self, 1.0
        return replace(self, contact=contact), 1.0 if contact.pitch is not None else float(factor)

    @property
    def has_size(self) -> bool:
        """Whether this form has lengths of its own that the pad can show."""
        return self.form in ("pillar", "frustum", "pyramidal", "spherical", "ridge")

    @property
    def size_interval(self) -> Sides:
        """Intervals ((low, high) of the long side, (low, high) of the short one) that hold the true ones in 90 %.

        They widen with what the sensor's state says of how far the taxels can be trusted.
        """
        return self.size_interval_of(height_map=False)

    def size_of(self, *, height_map: bool) -> tuple[float, float]:
        """Return the lengths (long, short); on a height map less what sizes of drawn ones are off, if it is whole."""
        if not height_map or self.cut:
            return self.size
        long, short = self._true_sides(height_map)[0]
        return max(long, 0.0), max(short, 0.0)

    def size_interval_of(self, *, height_map: bool) -> Sides:
        """Return the intervals of both sides, narrower where the frame is known to be a height map."""
        middle, half = self._true_sides(height_map and not self.cut)
        low, high = (np.maximum(middle + sign * half, 0.0).tolist() for sign in (-1, 1))
        return (low[0], high[0]), (low[1], high[1])

    def _true_sides(self, height_map: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the middle and the half-width of the intervals of both sides."""
        kind = int(np.argmax(self.kind_probability))
        middle, half = self.parameters.size_error(kind, self.inputs, height_map)
        sized, scale = self._on_scale
        unit = scale * math.sqrt(sized.contact.taxel_area)
        return self.size + unit * middle, unit * half

    @cached_property
    def orientation(self) -> float | None:
        """Angle of the long side (of one side, for a square) from +x toward +y, in [-pi/2, pi/2); None for circles."""
        if self.section == "circle" or self.form == "plane":
            return None
        _, c = self._sized_section()
        if self.section == "square":
            # The sections from half height down, together: one alone of a small pyramid is nearly round.
            return _square_angle(self.profile.extent[self.middle :].sum(axis=0))
        if self.form == "edge" and self.section == "field":
            return (self._border_angle() + _SQUARE_TURN) % math.pi - _SQUARE_TURN
        return float(principal_angle(c[0, 0], c[0, 1], c[1, 1]))

    @property
    def middle(self) -> int:
        """Index of the section nearest half height, where a taxel's averaging moves an upright border least.

        A section with holes or in parts is passed over where there are others: under a flat face on a thick
        skin the pressure at half height is a ring, or what noise leaves of it, and lower down the whole face.
        """
        profile = self.profile
        middle = 0.5 * (self.contact.peak + self.contact.floor)
        whole = (profile.area > 0) & (profile.holes == 0) & (profile.parts == 1)
        usable = whole if whole.any() else profile.area > 0
        return int(np.argmin(np.where(usable, np.abs(profile.threshold - middle), np.inf)))

    def breadths(self, level: int) -> tuple[float, float]:
        """Lengths (long, short) of the section at index `level`, taken for a section of this surface's outline."""
        return _sides(self.section, self.areas[level], self.profile.covariance[level])

    def _sized_section(self) -> tuple[float, NDArray[np.float64]]:
        """Return the area and the covariance of the section that the size belongs to."""
        profile = self.profile
        if self.form == "pillar":
            i = self.middle
            return float(profile.area[i]), profile.covariance[i]
        i = self.lowest
        if self.form != "frustum":
            return float(profile.area[i]), profile.covariance[i]
        # A frustum's breadth grows evenly with depth: the line through its flank meets the top at depth 0.
        depth = (self.contact.peak - profile.threshold) / (self.contact.peak - self.contact.floor)
        flank = (depth > 0.15) & (depth < 0.9) & (profile.area > 0)
        if flank.sum() < 3:
            return float(profile.area[i]), profile.covariance[i]
        _, top = np.polyfit(depth[flank], np.sqrt(profile.area[flank]), 1)
        share = max(float(top), 0.0) ** 2 / float(profile.area[i])
        return share * float(profile.area[i]), share * profile.covariance[i]

    def _border_angle(self) -> float:
        """Return the direction of a flat face's one border, from the steepest descent of the taxels along it.

        The first taxels beyond the contact count too: along the grid a sharp face ends between two of them.
        """
        contact = self.contact
        wider = tuple(
            slice(max(part.start - 1, 0), min(part.stop + 1, n))
            for part, n in zip(contact.window, contact.shape, strict=True)
        )
        own = contact.frame.label[1:-1, 1:-1][wider] == contact.index
        values = np.where(own, contact.frame.padded[1:-1, 1:-1][wider], contact.floor)
        if min(values.shape) < 2:
            return 0.0
        down_y, down_x = np.gradient(values, *contact.spacing)
        return math.atan2(float(down_y.sum()), float(down_x.sum())) + _SQUARE_TURN


def _sides(section: Section, area: float, covariance: NDArray[np.float64]) -> tuple[float, float]:
    """Return the (long, short) lengths of a section of known outline from its area and covariance."""
    if section == "circle":
        d = 2 * math.sqrt(area / math.pi)
        return d, d
    if section == "square":
        return math.sqrt(area), math.sqrt(area)
    if section == "hexagon":
        d = math.sqrt(8 * area / (3 * math.sqrt(3)))
        return d, d * math.sqrt(3) / 2
    if section == "triangle":
        side = math.sqrt(4 * area / math.sqrt(3))
        return side, side * math.sqrt(3) / 2
    major, minor = np.sqrt(principal_moments(covariance[0, 0], covariance[0, 1], covariance[1, 1]))
    if minor <= 0:
        return math.sqrt(12) * major, 0.0
    # The outline's area fixes the scale, its second moments the aspect: areas are the steadier of the two.
    aspect = major / minor
    product = 4 * area / math.pi if section == "ellipse" else area
    return math.sqrt(product * aspect), math.sqrt(product / aspect)


def _square_angle(extent: NDArray[np.float64]) -> float:
    """Return the direction of a square's side from its widths: they are least across its sides."""
    angle = np.arange(len(extent)) * math.pi / len(extent)
    phase = math.atan2(float(extent @ np.sin(4 * angle)), float(extent @ np.cos(4 * angle)))
    # Widths of a square go as |cos| + |sin| of the angle from a side: least, so fourth harmonic lowest, along it.
    turned = (phase + math.pi) / 4
    return (turned + math.pi / 4) % _SQUARE_TURN - math.pi / 4
