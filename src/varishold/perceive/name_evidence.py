"""What another recognizer says of an object's name: a likelihood over some of the names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_positive, is_number
from varishold.perceive.size_range import LEAST_SIZE_M, MOST_SIZE_M
from varishold.trust.fusion import MIXING

__all__ = ["NameEvidence", "SizePrior", "names_in_words"]

# Shares of one answer may be off their sum by rounding.
_ROUNDING = 1e-6
_MOST_NAMED = 4
# So many characters of a person's own numbers are repeated.
_MOST_SAID = 200


@dataclass(frozen=True)
class SizePrior:
    """What somebody says of a thing's pose that the examples of a library have too: its size, with how sure it is.

    Parameters
    ----------
    size_m, size_sigma_m : float
        Diameter or breadth, and its standard deviation. Metres.

    Raises
    ------
    InputError
        If a number is not positive and finite, or the size is none that a hand holds.
    """

    size_m: float
    size_sigma_m: float

    def __post_init__(self) -> None:
        for what, value in (("size_m", self.size_m), ("size_sigma_m", self.size_sigma_m)):
            as_positive(value, f"{what} of a pose")
        if not LEAST_SIZE_M <= self.size_m <= MOST_SIZE_M:
            raise InputError(
                f"size_m of a pose must lie in [{LEAST_SIZE_M:g}, {MOST_SIZE_M:g}] m, got {self.size_m:g}; "
                "is it in millimetres?"
            )

    def log_likelihood(self, log_sizes: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log-likelihood of each of these steps of size, as to their mean.

        Parameters
        ----------
        log_sizes : ndarray of shape (n,)
            Rising logarithms of sizes in metres, each the middle of a step that is as likely before; what lies beyond
            the first or the last is told as that.
        """
        sizes = np.exp(log_sizes)
        # No more finely than steps tell it: between the middles of two it would otherwise be found in neither.
        sigma = np.hypot(self.size_sigma_m, 0.5 * np.gradient(log_sizes) * sizes)
        said = np.exp(-0.5 * ((sizes - np.clip(self.size_m, sizes[0], sizes[-1])) / sigma) ** 2)
        # As with names: a share of what is said is about nothing, so that no size is ruled out.
        return np.asarray(np.log((1 - MIXING) * said / said.mean() + MIXING))


@dataclass(frozen=True)
class NameEvidence:
    """A calibrated answer of a recognizer that was learned elsewhere, as evidence for a `Perceiver`.

    Divided by the prior, an answer's probabilities are a likelihood: an answer that says no more than the prior changes
    nothing. A name that the recognizer does not know is neither likelier nor less likely for what it says.

    Parameters
    ----------
    source : str
        Who says it.
    probability : mapping of str to float
        Of every name that the recognizer knows; they sum to 1.
    prior : mapping of str to float, optional
        What the recognizer takes the same names for before it feels anything, each above 0. Default: even.
    p_value : float
        How rare it is that something the recognizer knows feels as strange to it; 1: it does not say. A prior's is
        weighed with how strange the thing feels.
    error : float
        At a p-value of at most this it refuses the thing as none of its names. It then says nothing of the name, and
        that the thing may be none of the library's objects.
    weight : float
        The power of the likelihood: below 1 where the source repeats what other evidence says.
    pose : SizePrior, optional
        What the source says of the thing's size; it counts for what it is, whatever the weight.

    Raises
    ------
    InputError
        If a number is out of its range (p-value, error and weight above 0 and at most 1), or the prior is of other
        names.

    Examples
    --------
    >>> said = NameEvidence("fingertip", {"cup": 0.9, "can": 0.1})
    >>> said.log_likelihood(("cup", "can", "ball")).round(2).tolist()
    [0.58, -1.57, 0.0]
    """

    source: str
    probability: Mapping[str, float]
    prior: Mapping[str, float] | None = None
    p_value: float = 1.0
    error: float = 0.05
    weight: float = 1.0
    pose: SizePrior | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.source, str) or not self.source.strip():
            raise InputError(f"who says a name must have a name, got {self.source!r}")
        if not self.source.isprintable() or len(self.source) > _MOST_SAID:
            raise InputError(
                f"who says a name must be called by at most {_MOST_SAID} printable characters, "
                f"got {_short(ascii(self.source))}"
            )
        said = _shares("probability", self.source, self.probability)
        prior = dict.fromkeys(said, 1 / len(said))
        if self.prior is not None:
            prior = _shares("prior", self.source, self.prior)
        if set(prior) != set(said) or min(prior.values()) <= 0:
            raise InputError(
                f"prior of {self.source!r} must be above 0 for each of {', '.join(said)}, got it for {', '.join(prior)}"
            )
        for what, value in (("p_value", self.p_value), ("error", self.error), ("weight", self.weight)):
            if not is_number(value) or not 0 < value <= 1:
                raise InputError(f"{what} of {self.source!r} must be a number above 0 and at most 1, got {value!r}")
        if not (self.pose is None or isinstance(self.pose, SizePrior)):
            raise InputError(f"pose of {self.source!r} must be a SizePrior, got {self.pose!r}")
        object.__setattr__(self, "probability", said)
        object.__setattr__(self, "prior", prior)

    @property
    def refused(self) -> bool:
        """Whether the recognizer takes the thing for none of its names."""
        return bool(self.p_value <= self.error)

    def log_likelihood(self, objects: Sequence[str]) -> NDArray[np.float64]:
        """Return the log-likelihood of each object, shape (n_objects,), but for a constant.

        Raises
        ------
        InputError
            If the recognizer knows none of them.
        """
        self.check_common(objects)
        if self.refused:
            return np.zeros(len(objects))
        prior = self.prior or {}
        odds = [self.probability[name] / prior[name] if name in prior else 1.0 for name in objects]
        # A share of every source's answers is about nothing, so that none contradicts others without end.
        return np.asarray(self.weight * np.log((1 - MIXING) * np.array(odds) + MIXING))

    def p_of_these(self, objects: Sequence[str]) -> float:
        """Return how rare it is that one of these objects gets an answer as much about other names, or as strange.

        Of answers that give so little to these objects, at most so large a share is about one of them.
        """
        ours = sum(p for name, p in self.probability.items() if name in objects)
        expected = sum(p for name, p in (self.prior or {}).items() if name in objects)
        return min(self.p_value, ours / expected) if expected else self.p_value

    def remarks(self, objects: Sequence[str]) -> tuple[str, ...]:
        """Return in words what is odd about the answer to somebody who knows these objects."""
        if self.refused:
            return (f"{self.source}: none of its names, p = {self.p_value:.3f}",)
        strange = [name for name in self.probability if name not in objects]
        share = sum(self.probability[name] for name in strange)
        if not strange or share < self.error:
            return ()
        who = names_in_words(strange)
        return (f"{self.source}: {share:.2f} of its answer is about {who}, which the library does not know",)

    def silence(self, objects: Sequence[str]) -> tuple[str, ...]:
        """Return in words of which objects nothing is said: a camera that has ruled them out would say 0.

        Examples
        --------
        >>> NameEvidence("camera", {"cup": 1.0}).silence(("cup", "can"))
        ('camera: says nothing of can, which it does not name; give 0 to what it has ruled out',)
        """
        unnamed = [name for name in objects if name not in self.probability]
        if self.refused or not unnamed:
            return ()
        return (
            f"{self.source}: says nothing of {names_in_words(unnamed)}, which it does not name; "
            "give 0 to what it has ruled out",
        )

    @property
    def touch(self) -> str:
        """Who says it: what a `Perceiver` calls a look at the thing."""
        return self.source

    @property
    def reasons(self) -> tuple[str, ...]:
        """What is said, in words."""
        order = sorted(self.probability, key=lambda name: -self.probability[name])[:2]
        size = "" if self.pose is None else f"; {1e3 * self.pose.size_m:.0f} mm ± {1e3 * self.pose.size_sigma_m:.0f}"
        return (f"{self.source}: {', else '.join(f'{name} {self.probability[name]:.2f}' for name in order)}{size}",)

    def check_common(self, objects: Sequence[str]) -> None:
        """Raise InputError if none of these objects is a name that the recognizer knows.

        :meta private:
        """
        if not any(name in self.probability for name in objects):
            raise InputError(
                f"{self.source!r} knows {names_in_words(self.probability)}, none of which is an object of the library; "
                f"it knows {names_in_words(objects)}"
            )


def _shares(what: str, source: str, given: object) -> dict[str, float]:
    if not isinstance(given, Mapping) or not given:
        got = "none" if isinstance(given, Mapping) else type(given).__name__
        raise InputError(f"{what} of {source!r} must be numbers by name, got {got}")
    if any(not isinstance(name, str) or isinstance(p, str | bool | np.bool_) for name, p in given.items()):
        raise InputError(f"{what} of {source!r} must be numbers by name, got {_short(given)}")
    try:
        shares = {name: float(p) for name, p in given.items()}
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} of {source!r} must be numbers by name, got {_short(given)}") from None
    if not all(p >= 0 for p in shares.values()) or abs(sum(shares.values()) - 1) > _ROUNDING:
        raise InputError(f"{what} of {source!r} must be from 0 to 1 and sum to 1, got {_short(shares)}")
    return shares


def names_in_words(names: Iterable[str]) -> str:
    """Return the first few names, and how many more there are."""
    first, rest = [*names][:_MOST_NAMED], [*names][_MOST_NAMED:]
    return ", ".join(first) + (f" and {len(rest)} more" if rest else "")


def _short(shares: object) -> str:
    text = str(shares)
    return text if len(text) <= _MOST_SAID else f"{text[:_MOST_SAID]} ..."
