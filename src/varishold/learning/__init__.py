"""Learning: a user's own surfaces and objects, from presses or whole grasps, with trust in what is said.

`TactileClassifier` learns and answers, `PortableClassifier` does so in a form that a controller can hold;
`labelled_presses` takes presses, labels and sessions from recordings;
`write_model` and `read_model` keep what was learned as plain arrays; `evidence_of_presses` gives a model's answers to a
`Perceiver`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "LabelledPresses",
    "PortableClassifier",
    "PressClassifier",
    "Recognition",
    "TactileClassifier",
    "evidence_of_presses",
    "labelled_presses",
    "read_model",
    "write_model",
]

if TYPE_CHECKING:
    from varishold.learning.classifier import TactileClassifier
    from varishold.learning.evidence import evidence_of_presses
    from varishold.learning.labels import LabelledPresses, labelled_presses
    from varishold.learning.model_file import read_model, write_model
    from varishold.learning.portable import PortableClassifier
    from varishold.learning.press_classifier import PressClassifier
    from varishold.learning.recognition import Recognition
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
