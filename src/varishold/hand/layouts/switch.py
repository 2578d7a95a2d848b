"""One on-off switch of a hand: its name and what it sits on."""

from __future__ import annotations

from dataclasses import dataclass, field

__all__ = ["Layout", "Switch"]


@dataclass(frozen=True)
class Switch:
    """An on-off switch.

    Parameters
    ----------
    name : str
        Its column's name after ``switch.`` in a grasp table.
    part : str
        "palm", or digit and phalanx, as in "index.distal".
    y_m, z_m : float
        A palm button's place in the palm's frame, metres. A phalanx's switch covers its whole phalanx.
    on_n : float, optional
        The force at which it closes. Newtons. Default: as `SwitchSetting` says of all.
    """

    name: str
    part: str
    y_m: float = 0.0
    z_m: float = 0.0
    # What was kept in files named after a hand's values stays good.
    on_n: float | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Layout:
    """A hand's switches in the order of their columns.

    Parameters
    ----------
    name : str
        The layout's name in `LAYOUTS`.
    switches : tuple of Switch
    """

    name: str
    switches: tuple[Switch, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(switch.name for switch in self.switches)
