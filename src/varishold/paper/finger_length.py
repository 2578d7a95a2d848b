"""Table 5 with digits of several lengths: the paper's closing remark."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from varishold.paper.table5 import Table5, table_5

__all__ = ["FingerLengthSweep", "finger_length_sweep"]


@dataclass(frozen=True)
class FingerLengthSweep:
    """Right answers against the length of the digits: the paper's closing remark.

    Parameters
    ----------
    finger_scales : tuple of float
    tables : tuple of Table5
        One a length.
    """

    finger_scales: tuple[float, ...]
    tables: tuple[Table5, ...]

    def to_dicts(self) -> Iterator[dict[str, Any]]:
        """Yield one mapping a length."""
        for scale, table in zip(self.finger_scales, self.tables, strict=True):
            yield {
                "finger_scale": scale,
                "percent": {g: [float(v) for v in table.percent(g)] for g in table.groups},
                "mean_percent": {g: table.mean(g)[0] for g in table.groups},
                "held_percent": float(100 * table.held.sum() / (10 * table.total)),
                "grasps": 10 * table.total,
            }

    def __str__(self) -> str:
        lines = []
        for scale, table in zip(self.finger_scales, self.tables, strict=True):
            lines.append(f"digits {scale:g} times the usual length\n{table}")
        return "\n\n".join(lines)


def finger_length_sweep(
    finger_scales: Sequence[float] = (0.8, 0.9, 1.0, 1.1, 1.2),
    *,
    grasps: int = 10,
    repetitions: int = 2,
    seed: int = 0,
    groups: Sequence[str] = ("contact", "contact+coordinates"),
    mode: str = "auto",
    processes: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FingerLengthSweep:
    """Repeat Table 5 with digits of several lengths; arguments as in `table_5`.

    The paper closes with: "The result of the experiment may be applied to the recognition of the object by
    adjusting the finger length in case of limited objects."
    """
    tables = []
    for n, scale in enumerate(finger_scales):

        def report(done: int, wanted: int, n: int = n) -> None:
            if progress is not None:
                progress(n * wanted + done, len(finger_scales) * wanted)

        tables.append(
            table_5(
                grasps=grasps,
                repetitions=repetitions,
                seed=seed,
                groups=groups,
                mode=mode,
                finger_scale=scale,
                processes=processes,
                progress=report,
            )
        )
    return FingerLengthSweep(tuple(float(scale) for scale in finger_scales), tuple(tables))
