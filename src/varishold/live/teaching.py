"""Things that are taught at the page: presses kept under the label that was set, and learned there and then."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock, Thread
from typing import TYPE_CHECKING, Any

from varishold._counted import counted
from varishold._name import plain_name
from varishold.errors import InputError, MissingExtraError
from varishold.live.press_keeper import KeptPress

if TYPE_CHECKING:
    from varishold.learning import TactileClassifier
    from varishold.touch.course.presses import Press

__all__ = ["LONGEST_LABEL", "MOST_LABELS", "MOST_PRESSES", "Teaching", "checked_label"]

#: A label's characters, how many labels there may be, and presses of each.
LONGEST_LABEL, MOST_LABELS, MOST_PRESSES = 60, 64, 200


class Teaching:
    """Keeps presses by label, and learns from them in a thread of its own.

    Parameters
    ----------
    on_learned : callable
        Called by that thread with the model when it has learned.
    """

    def __init__(self, on_learned: Callable[[TactileClassifier], object]) -> None:
        self._on_learned = on_learned
        self._lock = Lock()
        self._presses: dict[str, list[Press]] = {}
        self._label: str | None = None
        self._thread: Thread | None = None
        self._words = ""

    @property
    def label(self) -> str | None:
        """The label that presses are kept under now; None where they are not kept."""
        return self._label

    def set_label(self, label: str | None) -> None:
        """Keep presses under this label from now on; None for under none.

        Raises
        ------
        InputError
            If it is no label, or there are too many.
        """
        with self._lock:
            if label is not None:
                label = checked_label(label)
                if label not in self._presses and len(self._presses) >= MOST_LABELS:
                    raise InputError(f"there are {MOST_LABELS} labels already; learn from these")
                self._presses.setdefault(label, [])
            self._label = label

    def forget(self, label: str) -> None:
        """Forget the presses of a label."""
        with self._lock:
            self._presses.pop(label, None)
            if self._label == label:
                self._label = None

    def take(self, kept: KeptPress) -> tuple[str, int] | None:
        """Keep a press under the label that is set; return that and how many there are now, None if none is set."""
        with self._lock:
            if self._label is None:
                return None
            presses = self._presses.setdefault(self._label, [])
            if len(presses) >= MOST_PRESSES:
                del presses[0]
            presses.append(kept.press)
            return self._label, len(presses)

    def learn(self) -> None:
        """Begin to learn from all presses that were kept.

        Raises
        ------
        InputError
            If there is too little to learn from, or it is being learned.
        """
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                raise InputError("it is being learned; wait for it")
            known = {label: list(presses) for label, presses in self._presses.items() if presses}
            few = next((label for label, presses in known.items() if len(presses) < 2), None)
            if len(known) < 2 or few is not None:
                have = ", ".join(f"{label}: {len(presses)}" for label, presses in known.items()) or "none"
                raise InputError(
                    f"learning takes two labels or more with two presses or more of each; there are: {have}"
                )
            self._words = "learning"
            self._thread = Thread(target=self._learn, args=(known,), name="varishold learns", daemon=True)
            self._thread.start()

    def to_dict(self) -> dict[str, Any]:
        """Return how far it is: the label that is set, presses by label, and a word."""
        with self._lock:
            counts = [[label, len(presses)] for label, presses in self._presses.items()]
            return {"label": self._label, "counts": counts, "words": self._words}

    def close(self) -> None:
        """Wait until nothing is learned any more."""
        if self._thread is not None:
            self._thread.join()

    def _learn(self, known: dict[str, list[Press]]) -> None:
        labels = [label for label, presses in known.items() for _ in presses]
        try:
            from varishold.learning import TactileClassifier

            model = TactileClassifier().fit([press for presses in known.values() for press in presses], labels)
        except (InputError, MissingExtraError) as error:
            self._say(str(error))
            return
        self._on_learned(model)
        self._say(f"learned {counted(len(model.classes_), 'thing')} from {counted(len(labels), 'press')}")

    def _say(self, words: str) -> None:
        with self._lock:
            self._words = words


def checked_label(label: object) -> str:
    """Return a label that may be shown and written.

    Raises
    ------
    InputError
        If it is no text of a line.
    """
    kept = plain_name(label)
    if kept is None or len(kept) > LONGEST_LABEL:
        raise InputError(f"a label is a line of 1 to {LONGEST_LABEL} characters, got {str(label)[:LONGEST_LABEL]!r}")
    return kept
