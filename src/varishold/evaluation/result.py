"""What an evaluation found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from varishold.evaluation.figures import Figure
from varishold.evaluation.leaks import Leak
from varishold.evaluation.scores import Scores
from varishold.evaluation.shots import Shots

__all__ = ["Evaluation", "PeerScore", "StrangerScore"]


@dataclass(frozen=True)
class PeerScore:
    """What a peer got on the same presses.

    Parameters
    ----------
    features, learner : str
    right : Figure
    log_loss : Figure
        Nats.
    calibration_error : float
    ahead : Figure
        Share right of what is evaluated less the peer's, press by press.
    """

    features: str
    learner: str
    right: Figure
    log_loss: Figure
    calibration_error: float
    ahead: Figure

    @property
    def name(self) -> str:
        """What it is called."""
        return f"{self.features}, {self.learner}"


@dataclass(frozen=True)
class StrangerScore:
    """How presses of things that were not learned fared.

    Parameters
    ----------
    refused : Figure
        Share that is refused as none of these.
    refused_alike : float or None
        The same where as many known presses are refused as the classifier was asked for; None where nothing known was
        answered with a p-value.
    things : tuple of str
        What was a stranger.
    """

    refused: Figure
    refused_alike: float | None
    things: tuple[str, ...]

    def to_dict(self, leaks: list[str]) -> dict[str, Any]:
        """Return what JSON holds."""
        alike = None if self.refused_alike is None else round(self.refused_alike, 6)
        return {**self.refused.to_dict(), "refused_alike": alike, "things": list(self.things), "leaks": leaks}


@dataclass(frozen=True, eq=False)
class Evaluation:
    """How well things are told apart, and how far these figures may be believed.

    Parameters
    ----------
    tested : {"learned here", "model", "shipped"}
        What answered: what was learned in the evaluation without what was held out, a model, or the shipped names.
    n_presses : int
    things : tuple of str
        The classes, in the order of `Scores.confusion`.
    groups : tuple of str
        Names of the groups; empty where none were given.
    split : {"groups", "neighbours", "none"}
        What was held out together; "none" where nothing was learned.
    n_folds : int
        How many times something was learned.
    error : float or None
        Share of known presses that may be refused.
    scores : Scores
        Of presses whose thing was known.
    strangers : StrangerScore or None
        Things that were left out of learning in turn, or, where nothing was learned, that are not known.
    unheard : StrangerScore or None
        Presses of things that are in one group only: unknown where that is held out, and no errors.
    peers : tuple of PeerScore
        Best first.
    shots : tuple of Shots
    leaks : tuple of Leak
    remarks : tuple of str
    seed : int
    """

    tested: Literal["learned here", "model", "shipped"]
    n_presses: int
    things: tuple[str, ...]
    groups: tuple[str, ...]
    split: Literal["groups", "neighbours", "none"]
    n_folds: int
    error: float | None
    scores: Scores
    strangers: StrangerScore | None
    unheard: StrangerScore | None
    peers: tuple[PeerScore, ...]
    shots: tuple[Shots, ...]
    leaks: tuple[Leak, ...]
    remarks: tuple[str, ...]
    seed: int

    @property
    def best_peer(self) -> PeerScore | None:
        """The peer that was right most often, chosen after the fact."""
        return self.peers[0] if self.peers else None

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds; every figure names the leaks that spoil it."""
        spoilt = [leak.name for leak in self.leaks]
        s = self.scores

        def told(figure: Figure | None) -> dict[str, Any] | None:
            return None if figure is None else {**figure.to_dict(), "leaks": spoilt}

        def plain(value: float) -> dict[str, Any]:
            return {"value": round(value, 6), "leaks": spoilt}

        best = self.best_peer
        return {
            "tested": self.tested,
            "presses": self.n_presses,
            "things": list(self.things),
            "groups": list(self.groups),
            "split": {"kind": self.split, "folds": self.n_folds},
            "right": told(s.right),
            "chance": round(1 / len(self.things), 6),
            "macro_recall": plain(s.macro_recall),
            "log_loss": told(s.log_loss),
            "calibration_error": plain(s.calibration_error),
            "mean_p_minus_right": told(s.overstated),
            "sure": told(s.sure),
            "sure_right": told(s.sure_right),
            "known_refused": told(s.refused),
            "kept_right": told(s.kept_right),
            "error": self.error,
            "strangers": None if self.strangers is None else self.strangers.to_dict(spoilt),
            "unheard": None if self.unheard is None else self.unheard.to_dict(spoilt),
            "peers": [
                {
                    "features": peer.features,
                    "learner": peer.learner,
                    "right": told(peer.right),
                    "log_loss": told(peer.log_loss),
                    "calibration_error": plain(peer.calibration_error),
                    "ahead": told(peer.ahead),
                }
                for peer in self.peers
            ],
            "ahead_of_best_peer": None if best is None else told(best.ahead),
            "shots": [{**one.to_dict(), "leaks": spoilt} for one in self.shots],
            "confusion": s.confusion.tolist(),
            "reliability": [
                {"presses": b.n, "p": round(b.probability, 6), "right": round(b.right, 6), "low": round(b.low, 6)}
                | {"high": round(b.high, 6), "leaks": spoilt}
                for b in s.reliability
            ],
            "refusals": [
                {"refused": round(share, 6), "errors": round(errors, 6), "leaks": spoilt}
                for share, errors in s.refusals
            ],
            "leaks": [leak.to_dict() for leak in self.leaks],
            "remarks": list(self.remarks),
            "seed": self.seed,
        }
