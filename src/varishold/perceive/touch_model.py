"""How one touch of every example felt, and how likely another touch is under each of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.conformity import Calibration
from varishold.perceive.likelihood import log_mean, mean_by_kind, members_of_kinds, squared_distances, squares_from
from varishold.perceive.metric import Metric
from varishold.perceive.seen import SeenRange, seen_range
from varishold.perceive.size_model import SizeModel
from varishold.trust import share_interval

__all__ = [
    "SIGNIFICANCE",
    "TouchModel",
    "conformities",
    "squares_among",
    "tempered",
    "with_own_examples",
    "with_scores",
]

Floats = NDArray[np.float64]

# A touch that failed in an example may succeed another time, and the other way round, as often as this.
_CHANCE = 0.1

#: The significance at which a touch's power is told.
SIGNIFICANCE = 0.02

# Examples that are judged at once, which bounds the memory used.
_AT_ONCE = 500


@dataclass(frozen=True, eq=False)
class TouchModel:
    """How one touch of every example felt.

    Parameters
    ----------
    metric : Metric
        Of the numbers that tell shape.
    values : ndarray of shape (n, d)
        One row an example; all NaN where the touch was not made there.
    size : SizeModel or None
        What the numbers that tell size say; None where no example has a size.
    size_values : ndarray of shape (n, m)
    width, fall : float
        The kernel: likelihood is (1 + distance^2 / (d width^2)) ^ (-fall / 2).
    others : ndarray of shape (n_others, d)
        How the touch felt on other things, which the library does not name; may be empty.
    scores : ndarray of shape (n,)
        Conformity of each example: log-likelihood under the others of its object, less that under other things; NaN
        where the touch was not made.
    failed : ndarray of shape (n,), bool
        Examples in which the touch was tried and nothing was held.
    power : ndarray of shape (n_objects,)
        Of the tenth of other things that is most like each object, the share that this touch alone tells from it; NaN
        without other things.
    cost : float
        What the touch takes, in parts of the first.
    seconds : float or None
        What the touch takes a hand on the mean, letting go and coming there included; None where nobody measured it.
    optimism : ndarray of shape (n,), or None
        By how much each example's conformity is higher for the metric's having been learned from it; already taken off
        `scores`. None where the metric was not learned so.
    own : float
        The power of an example's own likelihood, in (0, 1], the rest being that of its kind: below 1 several touches
        need not all feel as those of one example.
    """

    metric: Metric
    values: Floats
    size: SizeModel | None
    size_values: Floats
    width: float
    fall: float
    others: Floats
    scores: Floats
    failed: NDArray[np.bool_]
    power: Floats
    cost: float
    seconds: float | None = None
    optimism: Floats | None = None
    own: float = 1.0

    @cached_property
    def made(self) -> NDArray[np.bool_]:
        """Which examples know this touch."""
        return np.asarray(np.isfinite(self.values).any(axis=1), dtype=np.bool_)

    def least_power(self, k: int) -> float:
        """Return the least that the k-th object's power may be, by how many other things it was counted on; or NaN.

        :meta private:
        """
        power, counted = float(self.power[k]), _most_alike(len(self.others))
        return share_interval(round(power * counted), counted)[0] if 0 <= power <= 1 else np.nan

    def log_success(self, owner: NDArray[np.int64], *, failed: bool) -> Floats:
        """Log-likelihood that the touch succeeds, or fails, for every example; shape (n,).

        Where it succeeded it may yet fail another time. Where it was not tried, its object's rate counts; where no
        example ever failed, or none was made, nothing is said.

        :meta private:
        """
        if not (self.failed.any() and self.made.any()):
            return np.zeros(len(owner))
        tried = self.made | self.failed
        fails = np.bincount(owner, weights=self.failed) + _CHANCE
        rate = fails / (np.bincount(owner, weights=tried) + 2 * _CHANCE)
        p = np.where(self.failed, 1 - _CHANCE, np.where(self.made, _CHANCE, rate[owner]))
        return np.log(p if failed else 1 - p)

    def of_examples(self, rows: NDArray[np.bool_], kinds: list[int]) -> Self:
        """Return a model of some of the examples, shape (n,), which are of these kinds; none is judged anew.

        :meta private:
        """
        return replace(
            self,
            values=self.values[rows],
            size_values=self.size_values[rows],
            scores=self.scores[rows],
            optimism=None if self.optimism is None else self.optimism[rows],
            failed=self.failed[rows],
            power=self.power[kinds],
            size=None if self.size is None else self.size.only(kinds),
        )

    @cached_property
    def seen(self) -> SeenRange:
        """What the examples have shown of each number."""
        return seen_range(self.metric, self.values)

    @cached_property
    def white(self) -> NDArray[np.float32]:
        """The examples, whitened; shape (n, d). A number that an example lacks counts as the mean.

        :meta private:
        """
        return (self._units @ self.metric.whitening).astype(np.float32)

    def log_kernel(self, values: Floats, *, rows: NDArray[np.int64] | None = None) -> Floats:
        """Log-likelihood of one touch under examples.

        Parameters
        ----------
        values : ndarray of shape (d,)
            NaN where unknown.
        rows : ndarray of shape (n_rows,), int, optional
            Which examples; default: all.

        Returns
        -------
        ndarray of shape (n_rows,)
            NaN for examples that do not know the touch; 0 where nothing at all is known of it.

        :meta private:
        """
        chosen = slice(None) if rows is None else rows
        known, made = np.isfinite(values), self.made[chosen]
        if not known.any():
            return np.zeros(len(made))
        examples = (self.white if known.all() else self._units)[chosen]
        return np.where(made, self._log_kernel(examples, values, known), np.nan)

    def log_others(self, values: Floats) -> float:
        """Log of the mean likelihood of one touch under all other things; 0 where there are none.

        :meta private:
        """
        known = np.isfinite(values)
        if not known.any() or not len(self.others):
            return 0.0
        examples = self.white_others if known.all() else self._units_of_others
        return float(log_mean(self._log_kernel(examples, values, known)))

    def _log_kernel(self, examples: NDArray[Any], values: Floats, known: NDArray[np.bool_]) -> Floats:
        """Log-likelihood under examples: whitened ones where everything is known, else ones in standard units."""
        units = self.metric.standardized(values)
        if known.all():
            off = examples - (units @ self.metric.whitening).astype(np.float32)
        else:
            part = examples[:, known] - units[known]
            off = part.astype(np.float32) @ self.metric.of(known).whitening.astype(np.float32)
        squares = np.einsum("nd,nd->n", off, off).astype(np.float64)
        return self.kernel(squares, int(known.sum()))

    def calibration(
        self,
        k: int,
        owner: NDArray[np.int64],
        known: NDArray[np.bool_] | None = None,
        log_size: Floats | None = None,
    ) -> Calibration:
        """Return the conformity of the k-th object's examples, which `owner` tells.

        Parameters
        ----------
        k : int
        owner : ndarray of shape (n,), int
        known : ndarray of shape (d,), bool, optional
            The numbers that are known of the touch to be judged; the examples are then judged by these alone.
        log_size : ndarray of shape (n,), optional
            Logarithm of all examples' sizes.

        :meta private:
        """
        key = (k, b"" if known is None or known.all() else known.tobytes())
        kept = self._calibrations.get(key)
        # Another library may share this model, and tell its examples otherwise.
        if kept is not None and kept[0] is owner and kept[1] is log_size:
            return kept[2]
        own = owner == k
        scores = self.scores[own] if known is None or known.all() else self._scores_by(own, known)
        made = Calibration(scores, None if log_size is None else log_size[own])
        self._calibrations[key] = owner, log_size, made
        return made

    def _scores_by(self, rows: NDArray[np.bool_], known: NDArray[np.bool_]) -> Floats:
        """As `scores`, of one object's examples by some numbers alone."""
        part = replace(
            self,
            metric=self.metric.of(known),
            values=self.values[rows][:, known],
            others=self.others[:, known],
            fall=self._fall(int(known.sum())),
        )
        alike = np.zeros(int(rows.sum()), dtype=np.int64), np.arange(int(rows.sum()))
        if self.optimism is None:
            whole = replace(self, values=self.values[rows])
            optimism = _better_by(conformities(whole, *alike), self.scores[rows])
        else:
            optimism = self.optimism[rows]
        return conformities(part, *alike) - optimism * float(known.mean())

    @cached_property
    def _calibrations(self) -> dict[tuple[int, bytes], tuple[NDArray[np.int64], Floats | None, Calibration]]:
        return {}

    @cached_property
    def white_others(self) -> NDArray[np.float32]:
        """Other things, whitened; shape (n_others, d).

        :meta private:
        """
        return (self._units_of_others @ self.metric.whitening).astype(np.float32)

    @cached_property
    def _units(self) -> Floats:
        """The examples in standard units, 0 for a number that one lacks."""
        return np.nan_to_num(self.metric.standardized(self.values), nan=0.0)

    @cached_property
    def _units_of_others(self) -> Floats:
        return np.nan_to_num(self.metric.standardized(self.others), nan=0.0)

    def kernel(self, squares: Floats, known: int) -> Floats:
        """Log-likelihood from squared distances over so many known numbers.

        :meta private:
        """
        return -0.5 * self._fall(known) * np.log1p(squares / (known * self.width**2))

    def _fall(self, known: int) -> float:
        """How fast likelihood falls where so many numbers are known: they say less, but much of what the others do."""
        return self.fall * float(np.sqrt(known / len(self.metric.names)))


def squares_among(model: TouchModel, rows: NDArray[np.int64]) -> Floats:
    """Squared distances of some examples from all, shape (n_rows, n); infinite from themselves and the unmade."""
    squares = squares_from(model.white, rows)
    squares[:, ~model.made] = np.inf
    return squares


def _better_by(one: Floats, other: Floats) -> Floats:
    """Return by how much examples conform better by one than by the other; 0 where nothing conforms by both."""
    out: Floats = np.subtract(one, other, out=np.zeros_like(one), where=~(np.isneginf(one) & np.isneginf(other)))
    return out


def with_scores(
    model: TouchModel, owner: NDArray[np.int64], judged: Iterable[tuple[NDArray[np.int64], Metric]] | None = None
) -> TouchModel:
    """Tell the conformity of the examples and the power of the touch.

    Parameters
    ----------
    model : TouchModel
    owner : ndarray of shape (n,), int
    judged : iterable of (ndarray of int, Metric), optional
        Examples, all of them in turn, and the metric by which each lot is judged. Default: all by the model's.
    """
    scores = np.full(len(owner), np.nan)
    for rows, metric in [(np.arange(len(owner)), model.metric)] if judged is None else judged:
        scores[rows] = conformities(replace(model, metric=metric), owner, rows)
    return _with_power(replace(model, scores=scores if model.optimism is None else scores - model.optimism), owner)


def conformities(model: TouchModel, owner: NDArray[np.int64], rows: NDArray[np.int64]) -> Floats:
    """Log-likelihood of examples, in rising order, under the others of their object, less that under other things."""
    out = np.full(len(rows), np.nan)
    made = rows[model.made[rows]]
    d, strange, members = len(model.metric.names), model.white_others, members_of_kinds(owner)
    for start in range(0, len(made), _AT_ONCE):
        part = made[start : start + _AT_ONCE]
        by_kind = mean_by_kind(model.kernel(squares_among(model, part), d), members)
        said = by_kind[np.arange(len(part)), owner[part]]
        if len(strange):
            said = said - log_mean(model.kernel(squared_distances(model.white[part], strange), d))
        out[np.searchsorted(rows, part)] = said
    return out


def _with_power(model: TouchModel, owner: NDArray[np.int64]) -> TouchModel:
    """Tell the power of the touch to detect other things, by those that are most like each object."""
    n_objects, d = int(owner.max()) + 1, len(model.metric.names)
    if len(model.others) < 2:
        return replace(model, power=np.full(n_objects, np.nan))
    strange = model.white_others
    squares = squared_distances(strange, model.white)
    squares[:, ~model.made] = np.inf
    among = squared_distances(strange, strange)
    np.fill_diagonal(among, np.inf)
    unnamed = log_mean(model.kernel(among, d), over=len(strange) - 1)
    odds = mean_by_kind(model.kernel(squares, d), members_of_kinds(owner)) - unnamed[:, None]
    power = np.full(n_objects, np.nan)
    for k in range(n_objects):
        usual = model.scores[(owner == k) & np.isfinite(model.scores)]
        if usual.size:
            alike = np.sort(odds[:, k])[-_most_alike(len(strange)) :]
            power[k] = float((alike <= np.quantile(usual, SIGNIFICANCE)).mean())
    return replace(model, power=power)


def _most_alike(others: int) -> int:
    """Return how many of so many other things are called most like an object: the tenth that is."""
    return max(1, others // 10)


def with_own_examples(model: TouchModel, owner: NDArray[np.int64], new: NDArray[np.int64]) -> TouchModel:
    """Return a model whose last rows are new: their conformity, and the power of the touch, are told anew."""
    scores = np.concatenate([model.scores, conformities(model, owner, new)])
    # The metric was not learned from them.
    optimism = None if model.optimism is None else np.append(model.optimism, np.zeros(len(new)))
    return _with_power(replace(model, scores=scores, optimism=optimism), owner)


def tempered(model: TouchModel, owner: NDArray[np.int64], share: float) -> TouchModel:
    """Return a model whose likelihoods are raised to the power of `share`."""
    rows = np.arange(len(owner))
    # By how much its examples conform better for what was learned from them.
    optimism = share * _better_by(conformities(model, owner, rows), model.scores)
    weaker = replace(
        model, fall=model.fall * share, optimism=None if model.optimism is None else share * model.optimism
    )
    return _with_power(replace(weaker, scores=conformities(weaker, owner, rows) - optimism), owner)
