"""``sim:`` a simulated skin that is pressed again and again; needs nothing but this package."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from varishold._counted import counted
from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.pace import Pace
from varishold.live.sample import UNNAMED_PAD, PadLayout, Sample
from varishold.live.simulated_skin import SimulatedSkin, SkinTraits
from varishold.live.sources.kind import SourceKind
from varishold.solids import SOLIDS

__all__ = ["KIND", "Simulated"]

_OPTIONS = (
    "seed",
    "rate_hz",
    "shape",
    "pitch_m",
    "noise",
    "drift",
    "creep",
    "moves",
    "hold_s",
    "rest_s",
    "pads",
    "speed",
    "duration_s",
)
# The device's clock: what it shows at first, and by what share it is fast.
_CLOCK_S, _FAST = 12.0, 40e-6


@dataclass(frozen=True)
class Timing:
    """How the frames of a simulated skin come.

    Parameters
    ----------
    rate_hz : float
        Frames a second of the skin's time.
    speed : float
        The skin's seconds in one of ours; 0 for as fast as it goes.
    duration_s : float
        Its time at the end; infinite where it has none.
    """

    rate_hz: float
    speed: float
    duration_s: float


class Simulated:
    """A simulated skin of one pad or several, each pressed for itself.

    Parameters
    ----------
    address : str
    traits : SkinTraits
    timing : Timing
    seed : int
    pads : int
        How many; several are called "pad1", "pad2" and so on.
    """

    def __init__(self, address: str, traits: SkinTraits, timing: Timing, *, seed: int, pads: int = 1) -> None:
        self._address = address
        self._traits = traits
        self._timing = timing
        names = [UNNAMED_PAD] if pads == 1 else [f"{UNNAMED_PAD}{number + 1}" for number in range(pads)]
        self._seeds = {name: seed + number for number, name in enumerate(names)}
        self._skins: dict[str, SimulatedSkin] = {}
        self._pace = Pace(timing.speed)
        self._sequence = 0

    @property
    def address(self) -> str:
        return self._address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        pitch_m = self._traits.pitch_m
        return dict.fromkeys(self._seeds, PadLayout(self._traits.shape, pitch_m=(pitch_m, pitch_m)))

    @property
    def skins(self) -> Mapping[str, SimulatedSkin]:
        """The skin of each pad, which knows what presses it; empty while the source is not open."""
        return self._skins

    def open(self) -> None:
        self._skins = {
            name: SimulatedSkin(self._traits, rate_hz=self._timing.rate_hz, seed=seed)
            for name, seed in self._seeds.items()
        }
        self._sequence = 0
        self._pace.restart()

    def read(self, timeout_s: float) -> list[Sample]:
        if not self._skins:
            raise LostSourceError(f"{self._address}: is not open")
        last = int(min(self._timing.duration_s * self._timing.rate_hz, 1e18))
        if self._sequence >= last:
            raise EndOfSourceError(f"{self._address}: {counted(self._sequence, 'frame')}, as long as was asked for")
        due = self._pace.due(self._due_s, self._sequence, last, timeout_s)
        return [self._next() for _ in range(due - self._sequence)]

    def close(self) -> None:
        self._skins = {}

    def _due_s(self, number: int) -> float:
        return (number + 1) / self._timing.rate_hz

    def _next(self) -> Sample:
        skin_s = self._sequence / self._timing.rate_hz
        pads = {name: skin.next_frame() for name, skin in self._skins.items()}
        host_s = self._pace.host_time_s(self._due_s(self._sequence))
        sample = Sample(_CLOCK_S + skin_s * (1 + _FAST), host_s, self._sequence, pads)
        self._sequence += 1
        return sample


def _make(address: Address) -> Simulated:
    address.only(*_OPTIONS)
    forms = tuple(SOLIDS) if address.place in ("", "all") else tuple(address.place.split(","))
    for form in forms:
        if form not in SOLIDS:
            raise InputError(f"{address.text}: no form is called {form!r}; known are all, {', '.join(SOLIDS)}")
    shape = address.shape() or (16, 16)
    if min(shape) < 4 or max(shape) > 256:
        raise InputError(f"{address.text}: a simulated skin has 4x4 to 256x256 taxels, got {shape[0]}x{shape[1]}")
    plain = SkinTraits(forms)
    hold_s = address.number("hold_s", 0.0, least=0.01, most=1e5)
    rest_s = address.number("rest_s", 0.0, least=0.01, most=1e5)
    traits = SkinTraits(
        forms,
        shape=shape,
        pitch_m=address.number("pitch_m", plain.pitch_m, least=1e-5, most=1.0),
        noise=address.number("noise", plain.noise, least=0, most=4095),
        drift=address.number("drift", plain.drift, least=-4095, most=4095),
        creep=address.number("creep", plain.creep, least=0, most=1),
        moves=address.number("moves", plain.moves, least=0, most=1),
        hold_s=(hold_s, hold_s) if hold_s else plain.hold_s,
        rest_s=(rest_s, rest_s) if rest_s else plain.rest_s,
    )
    timing = Timing(
        rate_hz=address.number("rate_hz", 100.0, least=0.1, most=1e5),
        speed=address.number("speed", 1.0, least=0, most=1e6),
        duration_s=address.number("duration_s", float("inf"), least=0, most=float("inf")),
    )
    seed = address.whole("seed", 0, least=0, most=2**31)
    return Simulated(address.text, traits, timing, seed=seed, pads=address.whole("pads", 1, least=1, most=64))


KIND = SourceKind("a simulated skin", "sim:sphere?seed=1", _make)
