"""How well logits tell names, by fault and by wear: the rows that training prints of what it held out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from training.faults import FAMILIES
from training.network import log_softmax
from training.readings import Readings
from varishold.touch import KINDS
from varishold.touch.names import NAMES, OUTLINE_OF, OUTLINES

_NAME = np.array([NAMES.index(kind.name) for kind in KINDS])
# Ridge and hip differ by one slope at the ends: they count as one.
_SAME = np.array([NAMES.index("ridge") if name == "hip" else i for i, name in enumerate(NAMES)])
_OUTLINE = np.array([OUTLINES.index(OUTLINE_OF[name]) for name in NAMES])
_WORN = ("rounded", "leaning", "over a bent pad", "cut", "stretched")
_FEWEST = 30


def print_rows(logits: NDArray[np.floating], held: Readings) -> None:
    """Print the shares of every fault and wear, a row each, for pads of 32, 16 and fewer rows."""
    p = np.exp(log_softmax(logits))
    by_name = np.stack([p[:, _NAME == i].sum(axis=1) for i in range(len(NAMES))], axis=1)
    by_outline = np.stack([by_name[:, _OUTLINE == i].sum(axis=1) for i in range(len(OUTLINES))], axis=1)
    truth, given, sure = _NAME[held.kind], by_name.argmax(axis=1), by_name.max(axis=1)
    right = _SAME[truth] == _SAME[given]
    outline = _OUTLINE[truth] == by_outline.argmax(axis=1)
    order = np.argsort(-by_name, axis=1, kind="stable")
    size = (np.cumsum(np.take_along_axis(by_name, order, axis=1), axis=1) < 0.9).sum(axis=1) + 1
    held_in = (order == truth[:, None]).argmax(axis=1) < size
    unknown = NAMES.index("unknown")
    known = truth != unknown
    bins = np.minimum((sure * 10).astype(int), 9)
    error = sum(abs(right[bins == b].mean() - sure[bins == b].mean()) * (bins == b).mean() for b in np.unique(bins))
    print(f"calibration error {error:.4f}")

    def row(what: str, chosen: NDArray[np.bool_]) -> None:
        named, strange = chosen & known, chosen & ~known
        if named.sum() < _FEWEST:
            return
        wrong = (~right & (sure > 0.9))[named].mean()
        text = (
            f"{what:26} {named.sum():6d} right {right[named].mean():.3f} outline {outline[named].mean():.3f} "
            f"unknown {(given[named] == unknown).mean():.3f} sure and wrong {wrong:.4f} "
            f"set {held_in[named].mean():.3f} of {size[named].mean():.2f}"
        )
        if strange.sum() >= _FEWEST:
            text += f" | strangers {right[strange].mean():.3f}, named {(~right & (sure > 0.9))[strange].mean():.3f}"
        print(text)

    worn = np.nan_to_num(held.wear)
    plain = ~worn.any(axis=1)
    count = np.array([bin(int(b)).count("1") for b in held.faults])
    for low, high in ((32, 64), (16, 17), (1, 12)):
        s = (held.shape[:, 0] >= low) & (held.shape[:, 0] < high)
        row(f"{low} rows", s)
        row(f"{low} rows, presses", s & (held.skin[:, 0] >= 0))
        row(f"{low} rows, clean", s & plain & (count == 0))
        for i, family in enumerate(FAMILIES):
            row(f"{low} rows, {family}", s & plain & (held.faults == 1 << i))
        row(f"{low} rows, several faults", s & plain & (count > 1))
        for i, way in enumerate(_WORN):
            row(f"{low} rows, {way}", s & (worn[:, i] > 0.02) & (count == 0))
