"""What a learned model says of presses, as evidence for a perceiver."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from varishold.perceive.name_evidence import NameEvidence

if TYPE_CHECKING:
    from varishold.learning.press_classifier import PressClassifier

__all__ = ["evidence_of_presses"]


def evidence_of_presses(
    model: PressClassifier, X: Any, *, source: str = "a learned model", weight: float = 1.0
) -> list[NameEvidence]:
    """Return what a learned model says of each press as evidence of the name.

    Parameters
    ----------
    model : PressClassifier
        Its probabilities are calibrated under an even prior, which they are divided by.
    X : sequence of presses
        As in `PressClassifier.predict`.
    source : str
        How reasons and remarks call it.
    weight : float
        The power of the likelihood: below 1 for several presses of one thing, which err alike.

    Returns
    -------
    list of NameEvidence
        One a press. What the model refuses says nothing of the name, and that it may be none of the library's objects.

    Raises
    ------
    InputError
        As `PressClassifier.predict`, or if the weight is not above 0 and at most 1.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold import TactileClassifier
    >>> from varishold.perceive import Evidence, Library, Perceiver
    >>> from varishold.solids import Cone, SquarePillar, ideal_frame
    >>> rng = np.random.default_rng(0)
    >>> frames = [ideal_frame(s, (12, 12), 1.0) + rng.normal(0, 0.05, (12, 12))
    ...           for s in (Cone(8.0, 4.0), SquarePillar(6.0, 4.0)) for _ in range(10)]
    >>> model = TactileClassifier().fit(np.array(frames), np.repeat(["cone", "pillar"], 10))
    >>> heavy, light = ([[Evidence("lift", {"mass": m})] for m in rng.normal(at, 1.0, 10)] for at in (8, 5))
    >>> perceiver = Perceiver(Library.from_examples({"cone": heavy, "pillar": light, "ball": light}))
    >>> perceiver.feel(Evidence("lift", {"mass": 5.0})).probability["pillar"] > 0.6
    False
    >>> (said,) = evidence_of_presses(model, np.array(frames[12:13]), source="fingertip")
    >>> update = perceiver.feel(said)
    >>> next(iter(update.probability)), update.probability["pillar"] > 0.6
    ('pillar', True)
    """
    names = [str(label) for label in model.classes_]
    probabilities, p_values = model.judge(X)
    return [
        NameEvidence(
            source, dict(zip(names, p.tolist(), strict=True)), p_value=float(p_value), error=model.error, weight=weight
        )
        for p, p_value in zip(probabilities, p_values, strict=True)
    ]
