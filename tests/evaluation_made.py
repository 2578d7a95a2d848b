"""An evaluation whose answers are drawn."""

from __future__ import annotations

import numpy as np

from varishold.evaluation import Evaluation, Leak
from varishold.evaluation.figures import difference_figure, mean_figure, share_figure
from varishold.evaluation.result import PeerScore, StrangerScore
from varishold.evaluation.scores import Answers, score
from varishold.evaluation.shots import Shots

__all__ = ["made"]


def made(n_things: int = 3, *, leaks: tuple[Leak, ...] = (), names: tuple[str, ...] = ()) -> Evaluation:
    """Return one of so many things, each pressed four times in each of three sessions."""
    rng = np.random.default_rng(0)
    truth = np.repeat(np.arange(n_things), 12)
    groups = np.tile(np.repeat(["mon", "tue", "wed"], 4), n_things)
    p = rng.dirichlet(np.full(n_things, 0.3), len(truth))
    p[np.arange(len(truth)), truth] += 1.0
    p /= p.sum(axis=1, keepdims=True)
    right = p.argmax(axis=1) == truth
    peer = PeerScore(
        *("moments", "forest", share_figure(right, groups), mean_figure(right, groups), 0.1),
        difference_figure(right, rng.random(len(right)) < 0.5, groups),
    )
    share = share_figure(right, groups)
    return Evaluation(
        tested="learned here",
        n_presses=len(truth),
        things=names or tuple(f"thing {k}" for k in range(n_things)),
        groups=("mon", "tue", "wed"),
        split="groups",
        n_folds=3,
        error=0.05,
        scores=score(Answers(p, truth, rng.random(len(truth)) < 0.1, groups)),
        strangers=StrangerScore(share, 0.5, ("thing 0",)),
        unheard=None,
        peers=(peer,),
        shots=(
            Shots(1, None, share),
            Shots(2, share_figure(right[::2]), share_figure(right[:9])),
            Shots(5, share, share_figure(right[1::2])),
            Shots(20, share_figure(~right), None),
        ),
        leaks=leaks,
        remarks=("a remark",),
        seed=0,
    )
