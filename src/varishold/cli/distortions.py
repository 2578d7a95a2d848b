"""``varishold evaluate --distortions``: what answers to the yardstick's frames are worth."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, Any

from varishold.cli.options import option_told
from varishold.cli.printing import echo, print_json

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from varishold.evaluation.yardstick import RowScore, ShapeScore, YardstickScore

__all__ = ["evaluate_distortions"]

_SHIPPED = "shipped"
_COLUMNS = ("right", "outline", "unknown", "wrong with p > .9")


def evaluate_distortions(
    given: str | None, shape: str | None, frames: int | None, seed: int | None, *, json: bool, **others: object
) -> None:
    """Score the shipped names or a user's function, and print the score.

    Parameters
    ----------
    given : str or None
        ``shipped``, which is the default, or a function as ``package.module:function``.
    shape : str or None
        ``16x16``, ``32x32`` or ``both``, which is the default.
    frames, seed : int or None
        Default: those of published figures.
    json : bool
        Whether one JSON object is printed.
    **others
        Options of presses that are recorded, which must not be given.
    """
    from varishold.cli.progress import progress_bar
    from varishold.errors import InputError
    from varishold.evaluation.yardstick import FRAMES, SEED, score_function, shipped_names

    for name, value in others.items():
        if value not in (None, []):
            what = "recordings" if name == "recordings" else option_told(name, value)
            raise InputError(f"--distortions draws its own frames: leave out {what}")
    shapes = _shapes(shape)
    tested = _SHIPPED if given is None else given
    # What a user's function prints is no part of the answer.
    with _nothing_printed():
        function = shipped_names if tested == _SHIPPED else _own_function(tested)
        with progress_bar("scoring") as update:
            found = score_function(
                function,
                shapes=shapes,
                frames=FRAMES if frames is None else frames,
                seed=SEED if seed is None else seed,
                tested=tested,
                tick=update,
            )
    if json:
        print_json(found.to_dict())
    else:
        _print(found)


@contextmanager
def _nothing_printed() -> Iterator[None]:
    """Send what is printed meanwhile to standard error, by Python or by what is compiled."""
    try:
        out, error = sys.__stdout__.fileno(), sys.__stderr__.fileno()  # type: ignore[union-attr]
    except (AttributeError, OSError, ValueError):
        with redirect_stdout(sys.stderr):
            yield
        return
    sys.stdout.flush()
    kept = os.dup(out)
    try:
        os.dup2(error, out)
        with redirect_stdout(sys.stderr):
            yield
    finally:
        os.dup2(kept, out)
        os.close(kept)


def _own_function(name: str) -> Callable[..., Any]:
    """Return a user's function; modules of the current folder are found too, after all that is installed."""
    from varishold.evaluation.yardstick import load_function

    here = os.getcwd()
    if here not in sys.path:
        sys.path.append(here)
    return load_function(name)


def _shapes(text: str | None) -> tuple[tuple[int, int], ...]:
    from varishold.errors import InputError
    from varishold.evaluation.yardstick import SHAPES

    known = {f"{rows}x{cols}": (rows, cols) for rows, cols in SHAPES}
    if text is None or text == "both":
        return SHAPES
    if text not in known:
        raise InputError(f"--shape must be {', '.join(known)} or both, got {text!r}")
    return (known[text],)


def _print(found: YardstickScore) -> None:
    from varishold.evaluation.yardstick import FRAMES, SEED

    echo(f"yardstick of distortions, version {found.version}: {found.tested}")
    for one in found.shapes:
        rows, cols = one.shape
        of_each = one.rows[0].frames
        echo(f"\n{rows} x {cols}, noise {one.noise:.0%}, {of_each} frames a row, seed {found.seed}")
        echo("  ".join([f"  {'row':24}", *(f"{name:>9}" for name in _COLUMNS)]))
        for row in one.rows:
            echo(_line(row.name + ("" if row.counted else " *"), row, row.right))
        echo(_line("mean of counted rows", one, one.right.value))
        echo(f"  right: {_interval(one)}; calibration error {one.calibration_error:.3f}")
    echo("\n* not counted")
    if not found.standard:
        echo(f"note: figures to be published are made with --frames {FRAMES} and --seed {SEED}, the defaults")


def _line(name: str, one: RowScore | ShapeScore, right: float) -> str:
    shares: tuple[Any, ...] = (right, one.outline, one.unknown, one.sure_wrong)
    cells = (f"{100 * share:.1f} %".rjust(max(len(name), 9)) for share, name in zip(shares, _COLUMNS, strict=True))
    return "  ".join([f"  {name:24}", *cells])


def _interval(one: ShapeScore) -> str:
    low, high = one.right.low, one.right.high
    if low is None or high is None:
        return f"{100 * one.right.value:.1f} %"
    return f"{100 * one.right.value:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"
