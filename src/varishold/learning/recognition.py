"""What is said about one press."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["Recognition"]


@dataclass(frozen=True, eq=False)
class Recognition:
    """An answer, how far it may be believed, and why.

    Parameters
    ----------
    label : object
        The likeliest class.
    probability : float
        Of that class. Where the press is as strange as what is refused, it is drawn towards an even share.
    alternatives : mapping of label to float
        Probabilities of the others of at least .01, falling.
    p_value : float
        How rare it is that a press of something known is as strange as this one.
    refused : bool
        Whether it looks like none of the classes: the p-value is at most the stated error.
    measures : tuple of (str, float)
        What decided: for the measures of each kind, by how many nats they speak for the label and against the next
        class; the strongest first.
    nearest : str
        Where the most similar training press stands.
    nearest_label : object
        Its class.
    place : str
        Where this press stands.
    outside : tuple of str
        Of a press that is refused: which kinds of measures lie outside of those of all training presses, the farthest
        first.
    unlike_session : bool
        Whether where it is felt, or how hard, is unlike the one session that was learned, so that what is known is
        judged by its form.
    adapted_to : int
        From how many unlabelled presses of this session its drift was estimated; 0: it was not.
    """

    label: Any
    probability: float
    alternatives: Mapping[Any, float]
    p_value: float
    refused: bool
    measures: tuple[tuple[str, float], ...]
    nearest: str
    nearest_label: Any
    place: str
    adapted_to: int = 0
    outside: tuple[str, ...] = ()
    unlike_session: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        return {
            "press": self.place,
            "label": str(self.label),
            "probability": round(self.probability, 6),
            "alternatives": {str(name): round(p, 6) for name, p in self.alternatives.items()},
            "p_value": round(self.p_value, 6),
            "refused": self.refused,
            "reasons": [{"measure": name, "nats": round(nats, 3)} for name, nats in self.measures],
            **({"outside": list(self.outside)} if self.outside else {}),
            **({"unlike_session": True} if self.unlike_session else {}),
            **({"adapted_to": self.adapted_to} if self.adapted_to else {}),
            "nearest": {"press": self.nearest, "label": str(self.nearest_label)},
        }
