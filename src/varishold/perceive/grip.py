"""Size from the grip: which section, of which size, lies against all touched parts of a hand at once.

Each touched part of the hand is a capsule: a straight line from one joint to the next and a radius. An object whose
horizontal section is a convex polygon (or a circle) of size s about c touches it where their distance is that
radius, be it with a side at a fingertip or with a corner along a phalanx. Middle and size follow by
least squares with bounded influence, the turn by trying. A section that grows with height adds one
unknown, which tells a cone from a cylinder.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require, require_a
from varishold.frame.checks import as_given, as_names
from varishold.perceive.section_fit import fit_ball, fit_turns, meeting

__all__ = [
    "GRIP_SECTIONS",
    "GripContacts",
    "GripSize",
    "Section",
    "SectionFit",
    "fit_ball_size",
    "fit_section",
    "grip_size",
]

Floats = NDArray[np.float64]

#: Standard deviation of how far a touched part is off the object, where the fit does not say more. Metres.
LEAST_SIGMA_M = 0.0005

# The fit begins at turns that are no farther apart than this. Radians.
_TURN_STEP_RAD = 0.3

# No part of a hand is farther from its palm; what is has been given in millimetres. Metres.
_REACH_M = 2.0

# A simulated or real hand gives way a little: parts lie deeper in the object than rigid geometry says. Metres.
_SINKS_M = 0.0005


@dataclass(frozen=True)
class GripContacts:
    """The parts of a hand about an object, as capsules in the palm's frame.

    Parameters
    ----------
    parts : tuple of str
        Names of the parts, as "index.distal": what stands before the dot moves together.
    start_m, end_m : ndarray of shape (n, 3)
        Ends of each part's middle line; z is the height along the gripped object. Metres.
    radius_m : ndarray of shape (n,)
        Metres.
    touched : ndarray of shape (n,), bool
        Which parts touch something. The others only say that the object is not where they are.
    half_height_m : ndarray of shape (n,), optional
        How far each part reaches up and down from its middle line; default: its radius. Metres.

    Raises
    ------
    InputError
        If the arrays do not belong together, are not finite, lie out of a hand's reach, or a radius is negative.
    """

    parts: tuple[str, ...]
    start_m: Floats
    end_m: Floats
    radius_m: Floats
    touched: NDArray[np.bool_]
    half_height_m: Floats | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", tuple(as_names(self.parts, "parts of grip contacts")))
        n = len(self.parts)
        if self.half_height_m is None:
            object.__setattr__(self, "half_height_m", self.radius_m)
        lengths = (("start_m", (n, 3)), ("end_m", (n, 3)), ("radius_m", (n,)), ("half_height_m", (n,)))
        for name, shape in lengths:
            try:
                array = np.array(getattr(self, name), dtype=np.float64)
            except (TypeError, ValueError, OverflowError):
                raise InputError(f"{name} of {n} grip contacts must be numbers of shape {shape}") from None
            require(array.shape == shape, f"{name} of {n} grip contacts must have shape {shape}, got {array.shape}")
            bad = np.flatnonzero(~np.isfinite(array.reshape(n, -1)).all(axis=1)) if n else np.array([], int)
            if bad.size:
                raise InputError(f"{name} of grip contact {self.parts[int(bad[0])]!r} must be finite")
            far = np.flatnonzero(np.abs(array.reshape(n, -1)).max(axis=1) > _REACH_M) if n else np.array([], int)
            if far.size:
                raise InputError(
                    f"{name} of grip contact {self.parts[int(far[0])]!r} is out of a hand's reach of {_REACH_M:g} m; "
                    "give metres from the palm"
                )
            object.__setattr__(self, name, array)
        if n and self.radius_m.min() < 0:
            raise InputError(f"radius_m of grip contact {self.parts[int(self.radius_m.argmin())]!r} is negative")
        given = as_given(self.touched, "touched of grip contacts must be true or false each")
        # A switch that is not known is no touch, and NaN would count as one.
        sure = given.dtype.kind in "biuf" and np.all((given == 0) | (given == 1))
        require(sure, "touched of grip contacts must be true or false each; leave out parts that cannot tell")
        touched = given.astype(np.bool_)
        require(touched.shape == (n,), f"touched of {n} grip contacts must have shape ({n},), got {touched.shape}")
        object.__setattr__(self, "touched", touched)

    def on_object(self) -> NDArray[np.bool_]:
        """Return which parts touch the object for certain: touched, and meeting no part of another digit."""
        meets: NDArray[np.bool_] = meeting(
            self.start_m,
            self.end_m,
            self.radius_m,
            self.radius_m if self.half_height_m is None else self.half_height_m,
            np.unique([part.split(".")[0] for part in self.parts], return_inverse=True)[1],
        )
        return self.touched & ~meets

    @cached_property
    def _touch(self) -> NDArray[np.int64]:
        """2 for parts that touch the object for certain, 1 for those that touch something, 0 for the others."""
        return self.touched.astype(np.int64) + self.on_object()

    @cached_property
    def _fits(self) -> dict[tuple[str, bool], SectionFit]:
        """What was fitted already: size, form and evidence ask for the same sections."""
        return {}


@dataclass(frozen=True)
class Section:
    """A section of size 1.

    Parameters
    ----------
    corners : ndarray of shape (n, 2)
        Its corners, anticlockwise; a single one for a circle's middle.
    radius : float
        What is added all round: one half for a circle, 0 for a polygon.
    period_rad : float
        The turn after which it looks the same. Radians.
    """

    corners: Floats
    radius: float
    period_rad: float


def _rectangle(long: float) -> Floats:
    return np.array([[long, 1.0], [-long, 1.0], [-long, -1.0], [long, -1.0]]) / 2


def _polygon(n: int) -> Floats:
    """A regular polygon of breadth 1 (from a side to the side or corner opposite), with a side across -x."""
    inner = 0.5 if n % 2 == 0 else 1.0 / (1.0 + 1.0 / np.cos(np.pi / n))
    angle = np.pi + np.pi / n + 2 * np.pi * np.arange(n) / n
    corners: Floats = inner / np.cos(np.pi / n) * np.column_stack([np.cos(angle), np.sin(angle)])
    return corners


#: The sections that are tried, by name.
GRIP_SECTIONS: Mapping[str, Section] = MappingProxyType(
    {
        "circle": Section(np.zeros((1, 2)), 0.5, 0.0),
        "square": Section(_rectangle(1.0), 0.0, np.pi / 2),
        "rectangle": Section(_rectangle(1.4), 0.0, np.pi),
        "hexagon": Section(_polygon(6), 0.0, np.pi / 3),
        "triangle": Section(_polygon(3), 0.0, 2 * np.pi / 3),
    }
)


@dataclass(frozen=True)
class SectionFit:
    """The section of one name that lies best against a grip.

    Parameters
    ----------
    section : str
        A key of `GRIP_SECTIONS`.
    size_m, sigma_m : float
        Its diameter or breadth at the palm's height, and the standard deviation of that. Metres.
    growth : float
        How much the size grows with height, 1; 0 where it was not asked for.
    turn_rad : float
        Its turn from the palm's x toward y, over one period.
    middle_m : (float, float)
        Its middle in the palm's x and y. Metres.
    off_m : ndarray of shape (n,)
        How far each part is off it: positive where a gap is left. Metres.
    cost : float
        Half of the sum of the bounded squares of `off_m` in parts of `LEAST_SIGMA_M`: a negative log-likelihood.
    """

    section: str
    size_m: float
    sigma_m: float
    growth: float
    turn_rad: float
    middle_m: tuple[float, float]
    off_m: Floats
    cost: float


@dataclass(frozen=True)
class GripSize:
    """What one grip says about size: as of a cylinder and as of a square pillar.

    Parameters
    ----------
    cylinder, pillar : SectionFit
    p_cylinder : float
        How likely the round one is of the two, from how well they fit alone.
    """

    cylinder: SectionFit
    pillar: SectionFit
    p_cylinder: float

    @property
    def size_m(self) -> float:
        """Diameter or breadth, of whichever is likelier. Metres."""
        return self._likelier.size_m

    @property
    def sigma_m(self) -> float:
        """Its standard deviation. Metres."""
        return self._likelier.sigma_m

    @property
    def _likelier(self) -> SectionFit:
        return self.cylinder if self.p_cylinder >= 0.5 else self.pillar


def grip_size(contacts: GripContacts) -> GripSize | None:
    """Return size, with its uncertainty, from joint angles and touched phalanges alone.

    Parameters
    ----------
    contacts : GripContacts

    Returns
    -------
    GripSize or None
        None where fewer than three parts touch.

    References
    ----------
    The first step of what Kinoshita, Aida and Mori conclude: size from the grip.

    Examples
    --------
    >>> turn = np.array([0.0, 2.0, -2.0, 2.7])  # a cylinder of 80 mm, touched from four sides by thin parts
    >>> out, along = np.stack([[np.cos(turn), np.sin(turn), 0 * turn], [-np.sin(turn), np.cos(turn), 0 * turn]])
    >>> touched = (np.array([[0.04], [0.0], [0.0]]) - 0.0405 * out).T
    >>> ends = touched - 0.01 * along.T, touched + 0.01 * along.T
    >>> size = grip_size(GripContacts(tuple("abcd"), *ends, 0.001 + 0 * turn, turn < 9))
    >>> round(size.cylinder.size_m, 3), size.p_cylinder > 0.5
    (0.08, True)
    """
    round_, square = fit_section(contacts, "circle"), fit_section(contacts, "square")
    if round_ is None or square is None:
        return None
    # The square's turn is one more number that was fitted.
    log_odds = square.cost - round_.cost + 0.5 * np.log(len(round_.off_m))
    return GripSize(round_, square, float(np.exp(-np.logaddexp(0.0, -log_odds))))


def fit_section(contacts: GripContacts, section: str, *, grows: bool = False) -> SectionFit | None:
    """Fit a section by least squares with bounded influence, its turn by trying.

    Parameters
    ----------
    contacts : GripContacts
    section : str
        A key of `GRIP_SECTIONS`.
    grows : bool
        Whether its size may change evenly with height.

    Returns
    -------
    SectionFit or None
        None where fewer than three parts touch.
    """
    require_a(GripContacts, contacts, "contacts", "where a hand's parts touch")
    known = isinstance(section, str) and section in GRIP_SECTIONS
    require(known, f"unknown section {section!r}; known are {', '.join(GRIP_SECTIONS)}")
    require(isinstance(grows, bool | np.bool_), f"grows must be True or False, got {grows!r}")
    if contacts.touched.sum() < 3:
        return None
    if (section, grows) not in contacts._fits:
        contacts._fits[section, grows] = _fit_section(contacts, section, grows=grows)
    return contacts._fits[section, grows]


def _fit_section(contacts: GripContacts, section: str, *, grows: bool) -> SectionFit:
    touch, shape = contacts._touch, GRIP_SECTIONS[section]
    tries = max(1, int(np.ceil(shape.period_rad / _TURN_STEP_RAD)))
    turns = shape.period_rad * np.arange(tries) / tries
    radius = contacts.radius_m - _SINKS_M
    found, off, costs, variance = fit_turns(
        contacts.start_m, contacts.end_m, radius, touch, shape.corners, shape.radius, turns, grows, LEAST_SIGMA_M
    )
    best = int(costs.argmin())
    free = max(1, int((touch == 2).sum()) - 3 - int(grows) - int(shape.period_rad > 0))
    # Turns that fit nearly as well say how unsure the turn leaves the size; a poor fit makes all of it less sure.
    worse = max(1.0, 2 * float(costs[best]) / free)
    share = np.exp(-costs / worse)
    share /= share.sum()
    mean = float(share @ found[:, 2])
    variance_m2 = worse * float(variance[best]) + float(share @ (found[:, 2] - mean) ** 2)
    return SectionFit(
        section=section,
        size_m=float(found[best, 2]),
        sigma_m=float(np.sqrt(variance_m2)),
        growth=float(found[best, 4]),
        turn_rad=float(found[best, 3]),
        middle_m=(float(found[best, 0]), float(found[best, 1])),
        off_m=off[best],
        cost=float(costs[best]),
    )


def fit_ball_size(contacts: GripContacts) -> tuple[float, float] | None:
    """Fit a ball at any height.

    Parameters
    ----------
    contacts : GripContacts

    Returns
    -------
    tuple of 2 floats, or None
        Diameter (metres) and cost, as of a `SectionFit`; None where fewer than three parts touch.
    """
    require_a(GripContacts, contacts, "contacts", "where a hand's parts touch")
    if contacts.touched.sum() < 3:
        return None
    radius = contacts.radius_m - _SINKS_M
    found, cost = fit_ball(contacts.start_m, contacts.end_m, radius, contacts._touch, LEAST_SIGMA_M)
    return float(found[3]), float(cost)
