"""How far an answer may be believed where the taxels themselves cannot show more."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.frame.neighbours import three_by_three
from varishold.levelset.contact import Contact
from varishold.levelset.second_moments import principal_moments
from varishold.touch.cut import corner_alone, cut_sides, ends_crookedly, falls_off_all_round, goes_across, half_hidden
from varishold.touch.decision import NAME_OF
from varishold.touch.names import KINDS, NAMES, OUTLINE_OF

if TYPE_CHECKING:
    from varishold.touch.surface import Surface

__all__ = [
    "FEWEST_LINES",
    "LIMITS",
    "Limit",
    "cautious",
    "ends_flat",
    "lines_across",
    "no_surer",
    "told_unknown",
    "unsure_of_plane",
    "unsure_of_smoothed",
    "unsure_of_top",
    "unsure_of_way",
]

#: Of a pad with fewer rows or columns nobody knows what is beyond: no form is sure.
FEWEST_LINES = 4
# Where several forms look the same, the likeliest is likelier than all others together, and not surely.
_ONE_OF_SEVERAL = 0.55
# A hole of broken taxels matters where it is this share of a contact, or taxels beside it read this share of the peak.
# The top shows all the same where so many taxels that are not beside it read so much of the peak, but for so many sigma
# of noise. A contact of fewer taxels is small.
_SMALL = 128
_HOLE_SHARE, _HIGH, _TOP, _FEWEST_OF_TOP, _NOISE_OF_TOP = 0.1, 0.5, 0.97, 3, 2.0
# Of a contact on fewer taxels than this that stand on no grid the form is no surer than that: between them it is a
# guess.
_FEW_OFF_GRID, _OFF_GRID = 48, 0.75
# So many of the contacts of which a border may hide half or more are what they look like, however far they go on.
_HALF_HIDDEN = 0.85
# At three quarters of its height a lying cylinder keeps so much of what it covers at one quarter: .58 on springs, .68
# on an elastic body (Hertz), and with noise no more than this. A flat bar keeps more where its breadth shows: under
# taxels and a cover that spreads by .7 of a taxel, as a Gaussian does, its two sides slope by so many taxels together
# between these heights, and by taxels alone by up to 2.0; small bars show no more than that.
_MOST_KEPT, _SLOPE = 0.72, 2.1
# A crest of fewer taxels across may be sharp, round or flat.
_CREST = 5.0
# A face that ends in one border, or in none, is whole; noise breaks off single taxels of it, not so many.
_PIECES = 6
# Smoothed readings have their form from the smoothing where it takes fewer taxels: no form is surer then.
_SMOOTHED, _SMOOTHED_TAXELS = 0.85, 256
# Of a contact more than this share of which is saturated, a flat top is believed no further than this in one look; the
# top of a frustum may be what is cut off a point.
_MOST_AT_END, _FLAT_AT_END = 1 / 3, 0.55
_MOST_SATURATED = {"pillar": _MOST_AT_END, "plane": _MOST_AT_END, "frustum": 0.05}
# Names of which one is the other's end.
_NEARLY_ONE = ("ridge", "hip")
# What nothing spoke for is as likely as this, beside the others.
_SPREAD = 1e-6


class Limit(NamedTuple):
    """What a pad or a contact may be that shows no form surely.

    Parameters
    ----------
    holds : callable
        Whether it is so of a surface and its contact with small gaps bridged, as it was named.
    most : float
        How sure a name may be then.
    says : str
        The reason; ``{across}`` is how many taxels the pad, or its part that is pressed, has across.
    outline : bool
        Whether the outline shows all the same, so that only its forms share what the name loses.
    unknown : bool
        Whether it limits what has no name, too.
    """

    holds: Callable[[Surface, Contact], bool]
    most: float
    says: str
    outline: bool = False
    unknown: bool = False


def cautious(surface: Surface, seen: Contact) -> Surface:
    """Return a surface, no surer than the pad can be, by the first of `LIMITS` that holds.

    `seen` is its contact with small gaps bridged, as it was named.
    """
    for limit in LIMITS:
        if (limit.unknown or surface.name != "unknown") and limit.holds(surface, seen):
            outline = OUTLINE_OF[surface.name]
            alike = np.array([OUTLINE_OF[kind.name] == outline for kind in KINDS]) if limit.outline else None
            return no_surer(surface, limit.most, among=alike)
    return surface


def narrow(_: Surface, seen: Contact) -> bool:
    """Tell whether a pad, or its part that is pressed, has so few rows or columns that nobody knows what is beyond."""
    return lines_across(seen) < FEWEST_LINES


def lines_across(contact: Contact) -> int:
    """Return the fewer of rows and columns of the part of the pad that a contact's peak is on, as of one fingertip."""
    if not contact.frame.has_gaps:
        return min(contact.shape)
    part = _parts_of(contact.field.tobytes(), contact.shape)
    own = part == part[contact.peak_taxel]
    return min(int(np.count_nonzero(own.any(axis=axis))) for axis in (0, 1))


def crooked(surface: Surface, seen: Contact) -> bool:
    """Tell whether much of a form's outline is a border of the pad that is not straight."""
    return surface.form not in ("plane", "unknown") and ends_crookedly(seen)


def goes_on(surface: Surface, seen: Contact) -> bool:
    """Tell whether a border of the pad may hide half of what touches, but for what goes on beyond it anyway."""
    return surface.form not in ("edge", "plane") and half_hidden(seen)


def flat_across(surface: Surface, seen: Contact) -> bool:
    """Tell whether a lying cylinder that goes on beyond the pad is as flat as a bar: its sections hardly grow."""
    if surface.name != "lying cylinder" or not cut_sides(seen):
        return False
    upper, lower = surface.nearest(0.25), surface.nearest(0.75)
    kept = surface.areas[upper] / surface.areas[lower]
    return kept > _MOST_KEPT or (seen.n_taxels < _SMALL and _as_upright(surface))


def crest_across(surface: Surface, seen: Contact) -> bool:
    """Tell whether an edge is a crest that leaves the pad at both ends, so narrow that it may be a bar."""
    return surface.form == "edge" and goes_across(seen) and _breadth(surface, surface.lowest) < _CREST


def in_pieces(surface: Surface, _: Contact) -> bool:
    """Tell whether an edge or a plane is many pieces, as of readings that came round at their end."""
    if surface.form not in ("edge", "plane"):
        return False
    return int(surface.profile.parts[surface.nearest(0.5)]) >= _PIECES


def _as_upright(surface: Surface) -> bool:
    """Tell whether a contact's breadth grows no more than where taxels and a cover spread upright sides."""
    return _breadth(surface, surface.nearest(0.75)) - _breadth(surface, surface.nearest(0.25)) < _SLOPE


def _breadth(surface: Surface, level: int) -> float:
    """Return how broad the section at index `level` is across its length, in taxels, as of a rectangle."""
    (xx, xy), (_, yy) = surface.profile.covariance[level].tolist()
    return math.sqrt(12.0 * float(principal_moments(xx, xy, yy)[1]) / surface.contact.taxel_area)


def bends(surface: Surface, seen: Contact) -> bool:
    """Tell whether a plane falls off to every border, as a ball or a cushion that is larger than the pad does."""
    return surface.form == "plane" and falls_off_all_round(seen)


def hides_its_ends(surface: Surface, seen: Contact) -> bool:
    """Tell whether of a square or a bar only one corner is seen: which of both it is nobody knows."""
    return surface.section in ("square", "rectangle") and surface.form in ("pillar", "frustum") and corner_alone(seen)


def shows_an_outline(surface: Surface, _: Contact) -> bool:
    """Tell whether all taxels of a form read exactly the same, as on-off taxels do: an outline without a form."""
    contact = surface.contact
    # Where there is noise readings are not all the same; an edge and a plane are outlines.
    if contact.frame.sigma > 0.0 or surface.form in ("edge", "plane", "unknown"):
        return False
    inside = contact.frame.padded[1:-1, 1:-1][contact.window]
    return bool((inside[contact.mask] == contact.peak).all())


def few_off_grid(_: Surface, seen: Contact) -> bool:
    """Tell whether a contact covers only a few of taxels that stand on no grid."""
    stands = seen.frame.losses.stands
    return stands is not None and int(np.count_nonzero(stands[seen.window] & seen.mask)) < _FEW_OFF_GRID


def lost_in_a_hole(_: Surface, seen: Contact) -> bool:
    """Tell whether a contact's top, or much of it, lies in a hole of broken taxels, or in a bridged gap.

    What fills a hole tells no form. A broken taxel with a working one beside it is none, but on a small contact four of
    them in a square are.
    """
    broken = seen.frame.losses.repaired
    if broken is None:
        return False
    taxels, values = seen.frame.label[1:-1, 1:-1] == seen.index, seen.frame.padded[1:-1, 1:-1]
    deep = np.all(three_by_three(broken, off_pad=True), axis=0) & taxels
    if np.count_nonzero(taxels) < _SMALL:
        deep |= _in_squares(broken) & taxels
    if not deep.any():
        return False
    if np.count_nonzero(deep) > _HOLE_SHARE * np.count_nonzero(taxels):
        return True
    working = taxels & ~broken
    rim = working & _beside(_beside(deep))
    peak = float(values[working].max(initial=0.0))
    if not (values[rim] >= _HIGH * peak).any():
        return False
    noise = seen.frame.sigma
    top = _TOP * peak - (_NOISE_OF_TOP * noise if noise > 0.0 else 0.0)
    return int(np.count_nonzero(values[working & ~_beside(broken)] >= top)) < _FEWEST_OF_TOP


#: Each is asked for in this order, and the first that holds limits the name.
LIMITS = (
    Limit(
        narrow,
        _ONE_OF_SEVERAL,
        "a pad, or a part of it that stands apart, of {across} across shows no form surely",
        unknown=True,
    ),
    Limit(
        crooked,
        _ONE_OF_SEVERAL,
        "much of its outline is a border of the pad that is not straight: what goes on beyond is not seen",
    ),
    Limit(
        few_off_grid,
        _OFF_GRID,
        "it covers only a few of taxels that stand on no grid: the form between them is guessed",
    ),
    Limit(
        shows_an_outline,
        _ONE_OF_SEVERAL,
        "all of its taxels read the same: on-off taxels show an outline, whatever stands on it",
        outline=True,
    ),
    Limit(
        lost_in_a_hole,
        _ONE_OF_SEVERAL,
        "no taxel works where its form would show, and what fills the hole tells none: any of its outline",
        outline=True,
    ),
    Limit(
        flat_across,
        _ONE_OF_SEVERAL,
        "it goes on beyond the pad and its sections hardly grow: a flat bar may look like this",
    ),
    Limit(
        in_pieces,
        _ONE_OF_SEVERAL,
        "it is many pieces, and what goes on beyond the pad is one: readings may have come round at their end",
    ),
    Limit(
        crest_across,
        _ONE_OF_SEVERAL,
        "it is a narrow crest that leaves the pad at both ends: an edge, or a bar, round or flat",
    ),
    Limit(
        bends,
        _ONE_OF_SEVERAL,
        "it falls off to every border: a plane, or a ball or a cushion that is larger than the pad",
    ),
    Limit(
        hides_its_ends,
        _HALF_HIDDEN,
        "two borders of the pad that meet cut it: how far it goes on either way is not seen",
    ),
    Limit(
        goes_on,
        _HALF_HIDDEN,
        "the border of the pad may hide half of it or more: how far it goes on beyond is not seen",
    ),
)


def unsure_of_plane(surface: Surface) -> Surface:
    """Return a surface, no surer of a plane than where a rest that drifts looks the same."""
    return no_surer(surface, _ONE_OF_SEVERAL) if surface.form == "plane" else surface


def unsure_of_smoothed(surface: Surface) -> Surface:
    """Return a surface, no surer than smoothed readings let a form of few taxels be."""
    return no_surer(surface, _SMOOTHED) if surface.contact.n_taxels < _SMOOTHED_TAXELS else surface


def unsure_of_way(surface: Surface) -> Surface:
    """Return a surface, no surer than where what looks pressed may be what was let go of."""
    return no_surer(surface, _ONE_OF_SEVERAL)


def told_unknown(surface: Surface) -> Surface:
    """Return a surface that is unknown: its readings tell no form."""
    kinds = np.zeros(len(surface.kind_probability))
    kinds[NAME_OF == NAMES.index("unknown")] = 1.0
    kinds /= kinds.sum()
    return replace(surface, name="unknown", form="unknown", section="unknown", probability=1.0, kind_probability=kinds)


def ends_flat(contact: Contact) -> bool:
    """Tell whether so much of a contact is saturated that a flat top may be the sensor's."""
    return contact.state.saturated > _MOST_AT_END * contact.n_taxels


def unsure_of_top(surface: Surface) -> Surface:
    """Return one look's surface, no surer of a flat top than the sensor lets it be; its name stays."""
    contact = surface.contact
    if contact.state.saturated > _MOST_SATURATED.get(surface.form, 1.0) * contact.n_taxels:
        return no_surer(surface, _FLAT_AT_END)
    return surface


@lru_cache(maxsize=16)
def _parts_of(field: bytes, shape: tuple[int, int]) -> NDArray[np.int32]:
    """Return the number of the part of the field that each taxel is on; those that touch at a corner are on one."""
    from scipy import ndimage

    parts, _ = ndimage.label(np.frombuffer(field, np.bool_).reshape(shape), np.ones((3, 3)))
    return np.asarray(parts, np.int32)


def _in_squares(where: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which places are one of four in a square; shape (rows, cols)."""
    four = where[1:, 1:] & where[1:, :-1] & where[:-1, 1:] & where[:-1, :-1]
    square = np.pad(four, 1)
    return square[1:, 1:] | square[1:, :-1] | square[:-1, 1:] | square[:-1, :-1]


def _beside(where: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which places are some of these, or stand beside one; shape (rows, cols)."""
    found: NDArray[np.bool_] = np.any(three_by_three(where, off_pad=False), axis=0)
    return found


def no_surer(surface: Surface, most: float, among: NDArray[np.bool_] | None = None) -> Surface:
    """Return a surface whose name is at most so probable, and stays the likeliest. A hip and a ridge are so together.

    Parameters
    ----------
    surface : Surface
    most : float
        Of 1, or of what the kinds of `among` have together.
    among : ndarray of shape (n_kinds,), bool, optional
        Which kinds share what the name loses. Default, and where there is none: all others.
    """
    alike = _NEARLY_ONE if surface.name in _NEARLY_ONE else (surface.name,)
    mine = np.isin(NAME_OF, [NAMES.index(name) for name in alike])
    kinds = surface.kind_probability
    together = float(kinds[mine].sum())
    shared = np.ones(len(kinds), np.bool_) if among is None or not (among & ~mine).any() else among | mine
    # Where nothing else was thought of, everything else is as likely.
    others = np.where(shared & ~mine, kinds + _SPREAD, 0.0)
    others /= others.sum()
    total, own = float(kinds[shared].sum()), surface.probability / together
    # The name stays the likeliest: beside each that gets what it loses, and each that has no share in that.
    most_of_others, besides = (
        float(np.bincount(NAME_OF, weights=each).max()) for each in (others, np.where(shared, 0.0, kinds))
    )
    limit = max(most * total, total * most_of_others / (own + most_of_others) + _SPREAD, besides / own + _SPREAD)
    if together <= limit:
        return surface
    shares = np.where(shared, others * (total - limit), kinds)
    shares[mine] = kinds[mine] * (limit / together)
    return replace(surface, probability=surface.probability * (limit / together), kind_probability=shares)
