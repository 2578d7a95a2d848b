"""Laws of holes in depth pictures: told where readings are 0 far below all others, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from varishold import Pad, Recording
from varishold.frame.holes import hole_share

USABLE = np.ones((20, 30), np.bool_)


def depth(seed: int = 0, share: float = 0.03) -> np.ndarray:
    """A camera that rests at 400 mm, with a ball 60 mm high, and sees nothing here and there."""
    rng = np.random.default_rng(seed)
    rows, cols = np.mgrid[:20, :30]
    ball = 60 * np.clip(1 - ((rows - 10) ** 2 + (cols - 15) ** 2) / 40, 0, None)
    frames = (400 - ball * (np.arange(40) > 20)[:, None, None] + rng.normal(0, 0.3, (40, 20, 30))).round()
    frames[rng.random(frames.shape) < share] = 0
    return frames.astype(np.uint16)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("share", [0.002, 0.03, 0.2])
def test_holes_are_counted_and_told(seed: int, share: float) -> None:
    frames = depth(seed, share)
    assert hole_share(frames, USABLE) == pytest.approx(share, rel=0.5)
    told = Recording({"cam": Pad(frames, polarity="down")}).remarks
    assert any(remark.startswith("pad cam: ") and "exactly 0, far below the others" in remark for remark in told)
    assert not any("exactly 0" in remark for remark in Recording({"cam": Pad(frames)}).remarks)


def test_what_has_no_holes_is_not_told() -> None:
    assert hole_share(depth(share=0.0), USABLE) == 0.0
    assert hole_share(np.zeros((5, 20, 30)), USABLE) == 0.0
    # A press that goes down to 0 passes all that lies between.
    ramp = np.linspace(1000, 0, 40)[:, None, None] * np.ones((40, 20, 30))
    assert hole_share(ramp, USABLE) == 0.0
    usable = USABLE.copy()
    usable[0] = False
    frames = depth(share=0.0)
    frames[:, 0] = 0
    assert hole_share(frames, usable) == 0.0
