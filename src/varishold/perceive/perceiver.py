"""The perceiver: takes evidence touch by touch, says what it believes and why, and what to touch next."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from varishold._counted import counted
from varishold.errors import InputError, require
from varishold.frame.checks import as_names, is_number
from varishold.perceive.belief import STRANGERS, Belief
from varishold.perceive.evidence import Evidence
from varishold.perceive.library import NONE_OF_THESE, Library
from varishold.perceive.library_file import shipped_library
from varishold.perceive.name_evidence import NameEvidence
from varishold.perceive.next_touch import NextTouch, expected_information, time_until_sure
from varishold.perceive.reasons import reasons_of
from varishold.trust import strange_share

__all__ = ["NONE_OF_THESE", "BeliefUpdate", "Perceiver", "Perception"]

#: A name is taken for sure after one, two, three touches only above this p-value; always above the last where another
#: sense has said how strange the thing looks.
_TYPICAL = (0.5, 0.15, 0.05)

# Two touches are looked ahead where none alone is expected to tell so much of what is in doubt: chosen on touches felt
# for that alone.
_ENOUGH = 0.8

Verdict = Literal["go on", "sure", "none of these", "enough"]


@dataclass(frozen=True)
class BeliefUpdate:
    """What is believed after one touch.

    Parameters
    ----------
    touch : str
    probability : dict of str to float
        Of each object of the library, were it one of them; largest first. Where what was felt is outside of what the
        library knows, drawn towards an even share: none is above .9 then.
    size_m : float or None
        Median size of the likeliest object. Metres.
    size_interval_m : (float, float) or None
        Holds the size with a probability of .95. Metres.
    p_value : float
        Conformal p-value of all touches so far for the likeliest object, or of other recognizers' answers if that is
        odder.
    verdict : {"go on", "sure", "none of these", "enough"}
    why : str
        Why it goes on or stops.
    reasons : tuple of str
        What the touch said, and what speaks for the likeliest object against the next.
    """

    touch: str
    probability: dict[str, float]
    size_m: float | None
    size_interval_m: tuple[float, float] | None
    p_value: float
    verdict: Verdict
    why: str
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Perception:
    """The answer.

    Parameters
    ----------
    object : str
        Name, or `NONE_OF_THESE`. Where the likeliest object is another one too (a pillar that lies is a box) and is not
        sure against that, the name that is true of both.
    probability : float
        Of an object, or of both that it may be, as in a `BeliefUpdate` less what is left for strangers; of none of
        these, that of a stranger among what feels as odd, of which known things are the p-value's share of theirs.
    size_m : float or None
        Diameter or breadth; None where it is not known, or no object is named. Metres.
    size_interval_m : (float, float) or None
        Holds the size with a probability of .95. Metres.
    alternatives : dict of str to float
        Probability of every other object of at least .01, largest first; of one that the named one may be, too.
    trace : tuple of BeliefUpdate
        One a touch.
    remarks : tuple of str
        What was odd about the evidence.
    pose : str or None, optional
        How the object lies, as its library calls it; None where that is not said, or no object is named.
    """

    object: str
    probability: float
    size_m: float | None
    size_interval_m: tuple[float, float] | None
    alternatives: dict[str, float]
    trace: tuple[BeliefUpdate, ...]
    remarks: tuple[str, ...]
    pose: str | None = None


class Perceiver:
    """Recognizes an object from touches of any hand.

    Parameters
    ----------
    library : Library, optional
        What is known; default: ten objects as the simulated hand feels them.
    error : float
        The error that is accepted: it stops when the likeliest object is at least so sure.
    least_touches, most_touches : int
        It never stops before, and always after so many.
    refuse : bool
        Whether it may answer that a thing is none of the library's objects.
    prior : NameEvidence or mapping of str to float, optional
        What is known of each object's name before it is touched, as a camera says it; it is no touch. A mapping gives
        the probability of every name, which sum to 1. Default: nothing.
    strangers : float
        How many of the things that it will meet are none of the library's, a share of at least 0 and below 1. The
        stated probability leaves so much for them, less as touches tell them from what it knows; at 0 it is that among
        the library's objects.
    pose : str, optional
        How the thing is set up, where that is known, as in "upright", "lying": it is compared with what was felt so.
        Default: any pose that the library tells; of the shipped one, upright.

    Raises
    ------
    InputError
        If a number is out of its range, the library knows none of the prior's names, or the shipped one no such pose.

    References
    ----------
    Baum and Veeravalli, "A sequential procedure for multihypothesis testing", 1994.
    """

    def __init__(
        self,
        library: Library | None = None,
        *,
        error: float = 0.01,
        least_touches: int = 1,
        most_touches: int = 4,
        refuse: bool = True,
        prior: NameEvidence | Mapping[str, float] | None = None,
        strangers: float = STRANGERS,
        pose: str | None = None,
    ) -> None:
        numbers = (least_touches, most_touches)
        broken = [n for n in numbers if isinstance(n, bool) or not isinstance(n, (int, np.integer))]
        if library is not None and not isinstance(library, Library):
            raise InputError(
                f"library must be a Library, made by from_examples or read_library; got {repr(library)[:40]}"
            )
        require(
            is_number(error) and 0 < error < 1,
            f"error must lie between 0 and 1, got {error!r}",
        )
        require(not broken, f"numbers of touches must be whole, got {[*broken, 0][0]!r}")
        require(
            1 <= least_touches <= most_touches,
            f"touches must be 1 <= least <= most, got least_touches={least_touches}, most_touches={most_touches}",
        )
        require(isinstance(refuse, bool | np.bool_), f"refuse must be True or False, got {refuse!r}")
        self._given = library
        self.error, self.least_touches, self.most_touches = error, least_touches, most_touches
        self.refuse, self.strangers = refuse, strangers
        self.prior = prior if prior is None or isinstance(prior, NameEvidence) else NameEvidence("prior", prior)
        self._pose, self._in_poses = pose, dict[str | None, Library]()
        self.forget()

    def forget(self, *, pose: str | None = None) -> None:
        """Begin anew, with another object of which no more is known than the prior, and how it is set up.

        Parameters
        ----------
        pose : str, optional
            How this one is set up; default: as the perceiver was told. A library that tells no such pose counts as it
            is; the shipped ones refuse it by an `InputError`.
        """
        told = self._pose if pose is None else pose
        require(told is None or isinstance(told, str), f"pose must be a word, got {type(told).__name__}")
        # What is known in each pose is kept: it has made ready for touches.
        self.library = self._in_poses[told] = self._in_poses.get(told) or _in_pose(self._given, told)
        # What is believed now, and what was after the last touch that was felt: one may have failed since.
        self.belief = self._felt = Belief.before(self.library, self.prior, strangers=self.strangers)
        self._trace: list[BeliefUpdate] = []

    def feel(self, evidence: Evidence | NameEvidence) -> BeliefUpdate:
        """Take the evidence of one touch, or what another recognizer says of the name.

        Raises
        ------
        InputError
            If it is no evidence, or the library does not know such a touch or none of the recognizer's names; the
            belief stays as it was.
        """
        what = type(evidence).__name__
        require(isinstance(evidence, (Evidence, NameEvidence)), f"feel takes Evidence or NameEvidence, got {what}")
        belief = self.belief = self._felt = self.belief.after(evidence)
        verdict, why = self._verdict()
        size = belief.size()
        told = evidence.reasons if self._trace or self.prior is None else (*self.prior.reasons, *evidence.reasons)
        update = BeliefUpdate(
            touch=evidence.touch,
            probability=belief.believed,
            size_m=None if size is None else size[0],
            size_interval_m=None if size is None else size[1:],
            p_value=belief.p_value,
            verdict=verdict,
            why=why,
            reasons=(*told, *reasons_of(evidence, belief)) if isinstance(evidence, Evidence) else told,
        )
        self._trace.append(update)
        return update

    def failed(self, touch: str) -> None:
        """Say that a touch was tried and nothing was held or met, and that the object was put at a new place for it.

        A second failure of the same touch says nothing more. A touch that the library does not know says nothing.
        """
        require(isinstance(touch, str), f"a touch has a name, got {touch!r}")
        if touch in self.library.touches and touch not in self.belief.touches:
            self.belief = self.belief.after(Evidence(touch, {}, failed=True))
        self.moved()

    def moved(self) -> None:
        """Say that the object was moved, as after a fall: object and size stay, its pose is unknown again."""
        self.belief = self.belief.in_new_place()

    @property
    def stopped(self) -> bool:
        """Whether enough is known."""
        return bool(self._trace) and self._trace[-1].verdict != "go on"

    def next_touch(self, among: Iterable[str] | None = None) -> tuple[str, float] | None:
        """Return the touch that is wanted next, and how much it should tell about the name (nats).

        Parameters
        ----------
        among : iterable of str, optional
            As `plan` takes it.

        Returns
        -------
        tuple of str and float, or None
            None where nothing can be done.
        """
        wanted = self.plan(among)
        return None if wanted is None else (wanted.touch, wanted.nats)

    def plan(self, among: Iterable[str] | None = None) -> NextTouch | None:
        """Return the touch that is expected to tell most about the name a second, and what it is chosen for.

        Where no touch alone is expected to tell four fifths of what is in doubt, two are looked ahead: the touch is
        wanted from which on it takes least until the name is sure. Where the library does not know how long all its
        touches take, their costs count instead, and one is looked ahead.

        Parameters
        ----------
        among : iterable of str, optional
            What can be done; default: every touch that was not made yet.

        Returns
        -------
        NextTouch or None
            None where nothing can be done.
        """
        touches, seconds = self.library.touches, self.library.seconds
        takes = {touch: model.cost for touch, model in touches.items()} if seconds is None else seconds
        can = [t for t in touches if t not in self.belief.touches] if among is None else as_names(among, "among")
        known = [touch for touch in can if touch in touches]
        # What was felt whole where the object lies tells nothing more, of the name or of strangers.
        here = self.belief.here
        anew = [touch for touch in known if touch not in here or not here[touch].whole]
        gains = {touch: expected_information(self.belief, touch) for touch in anew or known}
        if not gains:
            return None
        k = self.belief.best_kind
        powers = {touch: float(np.nan_to_num(touches[touch].power[k])) for touch in gains}
        along_with = None
        if self._named and max(powers.values()) > 0:
            # The name is sure, were it one of the library's: what would best reveal that it is another thing?
            best = max(gains, key=lambda touch: powers[touch] / takes[touch])
        else:
            best = max(gains, key=lambda touch: gains[touch] / takes[touch])
            if seconds is not None and len(gains) > 1 and max(gains.values()) < _ENOUGH * self._doubt:
                ahead = time_until_sure(self.belief, {touch: takes[touch] for touch in gains}, self.error)
                best = min(ahead, key=lambda touch: ahead[touch][0], default=best)
                along_with = ahead[best][1] if ahead else None
        return NextTouch(best, gains[best], touches[best].seconds, along_with)

    @property
    def _doubt(self) -> float:
        """Entropy of the name, were it one of the library's. Nats."""
        return -sum(p * math.log(p) for p in self.belief.probability.values() if p > 0)

    @property
    def _named(self) -> bool:
        """Whether the likeliest object is sure, were it one of the library's."""
        return bool(self._trace) and next(iter(self.belief.probability.values())) >= 1 - self.error

    def answer(self) -> Perception:
        """Return the answer so far: while another touch is asked for, none of these where the evidence is atypical.

        Raises
        ------
        InputError
            If nothing was touched.
        """
        require(self._trace, "nothing was touched yet; feel at least one touch")
        last = self._trace[-1]
        felt = self._felt
        name, p = felt.said
        others = {other: q for other, q in last.probability.items() if q >= 0.01}
        if last.verdict == "none of these" or (last.verdict == "go on" and self.refuse and self.belief.atypical):
            return Perception(
                NONE_OF_THESE,
                strange_share(last.p_value, self.strangers),
                None,
                None,
                others,
                tuple(self._trace),
                self.belief.remarks,
            )
        others.pop(name, None)
        size = felt.size(name)
        return Perception(
            name,
            p,
            None if size is None else size[0],
            None if size is None else size[1:],
            others,
            tuple(self._trace),
            self.belief.remarks,
            felt.pose,
        )

    def _verdict(self) -> tuple[Verdict, str]:
        # A touch that failed is no touch felt.
        belief, n = self.belief, len(self._trace) + 1
        name, p = next(iter(belief.probability.items()))
        often = f"{100 * belief.p_value:.3g} % of its own examples conform no better"
        if n < self.least_touches:
            return "go on", f"at least {counted(self.least_touches, 'touch is', 'touches are')} asked for"
        if self.refuse and belief.atypical:
            usual = belief.looks_usual
            if n >= (self.most_touches if usual else min(2, self.most_touches)):
                return "none of these", f"no object of the library explains the touches: {often}"
            seems = " but usual as it looked" if usual else ""
            return "go on", f"atypical for a {name}{seems}: {often}; another touch will tell"
        if p >= 1 - self.error and (belief.inside > 1 or n < self.most_touches):
            least = _TYPICAL[-1] if belief.seen is not None else _TYPICAL[min(n, len(_TYPICAL)) - 1]
            typical = not self.refuse or belief.p_value_with_sight > least
            if belief.inside > 1 and (n >= self.most_touches or typical):
                return "sure", f"{name} with probability {p:.4f}, and {often}"
            return "go on", f"{name}, were it one of these; but {often}: is it another thing?"
        if n >= self.most_touches:
            said, share = belief.said
            perhaps = "" if said == name else f", perhaps a {name} ({belief.believed[name]:.2f})"
            allowed = counted(self.most_touches, "touch was", "touches were")
            return "enough", f"{allowed} allowed; {said} with probability {share:.2f}{perhaps}"
        first_two = [f"{each} {share:.2f}" for each, share in belief.probability.items()][:2]
        return "go on", " against ".join(first_two)


def _in_pose(library: Library | None, pose: str | None) -> Library:
    """Return what is known of things in a pose; None: by the shipped libraries, or in any."""
    if library is None:
        return shipped_library() if pose is None else shipped_library(pose)
    return library.in_pose(pose) if pose in library.poses else library
