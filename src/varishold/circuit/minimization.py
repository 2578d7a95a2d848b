"""Two-level minimization: the fewest product terms that are true on one set of patterns and false on another.

What stands in neither set is a don't-care. A term that covers an on-pattern p must differ from every
off-pattern q in at least one literal, so its literals hit every set {variables in which p and q differ};
the prime implicants that cover p are the minimal hitting sets. The primes of all on-patterns and a
minimum cover by them give the exact answer; where there are too many primes, the best of several greedy
expansions of every pattern stand for them, and the answer is a good one instead of the best.

References
----------
E. J. McCluskey, "Minimization of Boolean functions", Bell System Technical Journal 35, 1956.
R. K. Brayton et al., "Logic minimization algorithms for VLSI synthesis", 1984 (espresso).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from varishold.errors import InputError
from varishold.frame.checks import as_given

__all__ = ["Cover", "minimize"]

Literals = tuple[tuple[int, int], ...]

# Primes of one pattern, and of all, above which enumerating them stops being quick.
_MOST_PRIMES_EACH: Final = 2_000
_MOST_PRIMES: Final = 20_000
# Entries of the table of primes and patterns up to which a minimum cover is sought by branch and bound.
_LARGEST_EXACT_TABLE: Final = 1_000_000
_MOST_NODES: Final = 1_000
_EXPANSIONS: Final = 12


@dataclass(frozen=True, slots=True)
class Cover:
    """A sum of products.

    Parameters
    ----------
    terms : tuple of tuple of (int, int)
        For every product its literals (variable, wanted value 0 or 1), sorted; a product without
        literals is always true, and no products at all are always false.
    proved : bool
        Whether no sum of products has fewer terms, or as few with fewer literals.
    """

    terms: tuple[Literals, ...]
    proved: bool

    def __call__(self, patterns: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return whether the sum is true, for patterns of shape (n, n_variables)."""
        values = np.asarray(patterns)
        out = np.zeros(len(values), np.bool_)
        for literals in self.terms:
            true = np.ones(len(values), np.bool_)
            for variable, wanted in literals:
                true &= values[:, variable] == wanted
            out |= true
        return out


def minimize(on: npt.ArrayLike, off: npt.ArrayLike, *, exact: bool | None = None) -> Cover:
    """Return a sum of few products, true on `on` and false on `off`; elsewhere it may be either.

    Parameters
    ----------
    on, off : array_like of shape (n, n_variables), 0 or 1
        Patterns; repeated ones count once, and their order does not matter.
    exact : bool, optional
        True insists on a proved minimum however long it takes, False takes the greedy way; by default
        the minimum is proved where that is quick.

    Returns
    -------
    Cover
        Fewest terms first, fewest literals among these; the same for the same sets.

    Raises
    ------
    InputError
        Where a pattern stands in both sets, is not binary, or the numbers of variables differ.

    Examples
    --------
    The circuit of the paper, over the signs of its hyperplanes I and III:

    >>> minimize([[1, 0]], [[0, 1], [1, 1], [0, 0]]).terms
    (((0, 1), (1, 0)),)
    """
    on_set, off_set = _patterns(on, "on"), _patterns(off, "off")
    if len(on_set) == 0 or len(off_set) == 0:
        return Cover(((),) if len(on_set) else (), True)
    if on_set.shape[1] != off_set.shape[1]:
        raise InputError(
            f"on and off must have the same number of variables, got {on_set.shape[1]} and {off_set.shape[1]}"
        )
    both = {row.tobytes() for row in on_set} & {row.tobytes() for row in off_set}
    if both:
        pattern = np.frombuffer(min(both), np.uint8).tolist()
        raise InputError(f"on and off must have no pattern in common, got {pattern} in both")
    found = None if exact is False else _all_primes(on_set, off_set, limited=exact is None)
    proved = found is not None
    if found is None:
        found = _expanded(on_set, off_set)
    primes = sorted(found, key=lambda literals: (len(literals), literals))
    covers = np.stack([_covered(literals, on_set) for literals in primes])
    chosen, minimum = _greedy_cover(covers), False
    if exact or (proved and covers.size <= _LARGEST_EXACT_TABLE):
        chosen, minimum = _minimum_cover(covers, [len(literals) for literals in primes], chosen, limited=not exact)
    proved = proved and minimum
    return Cover(tuple(sorted(primes[k] for k in chosen)), proved)


def _patterns(patterns: npt.ArrayLike, name: str) -> npt.NDArray[np.uint8]:
    must = f"{name} must have shape (n_patterns, n_variables)"
    values = as_given(patterns, must)
    if values.shape == (0,):
        values = values.reshape(0, 0)
    if values.ndim != 2:
        raise InputError(f"{must}, got {values.shape}")
    if values.dtype.kind not in "biuf" or not np.isin(values, (0, 1)).all():
        raise InputError(f"{name} must hold 0 and 1 only")
    # Without variables there is one pattern, and it holds nothing: a single class needs no hyperplane.
    return np.unique(values.astype(np.uint8), axis=0)


def _all_primes(on: npt.NDArray[np.uint8], off: npt.NDArray[np.uint8], *, limited: bool) -> set[Literals] | None:
    primes: set[Literals] = set()
    for pattern in on:
        hitting = _minimal_hitting_sets(_differences(pattern, off), _MOST_PRIMES_EACH if limited else None)
        if hitting is None:
            return None
        primes.update(_literals(variables, pattern) for variables in hitting)
        if limited and len(primes) > _MOST_PRIMES:
            return None
    return primes


def _differences(pattern: npt.NDArray[np.uint8], off: npt.NDArray[np.uint8]) -> list[int]:
    """Return the variables in which the pattern differs from every off-pattern, as bit sets, smallest first."""
    sets = {sum(1 << int(k) for k in np.flatnonzero(row)) for row in off != pattern}
    # a set that contains another is hit with it
    ordered = sorted(sets, key=lambda s: (s.bit_count(), s))
    kept: list[int] = []
    for candidate in ordered:
        if not any(other & candidate == other for other in kept):
            kept.append(candidate)
    return kept


def _minimal_hitting_sets(sets: Sequence[int], most: int | None) -> list[int] | None:
    """Return all minimal sets of variables that meet every set (Berge), or None if they pass `most`."""
    hitting = [0]
    for wanted in sets:
        already = [h for h in hitting if h & wanted]
        grown = {h | 1 << k for h in hitting if not h & wanted for k in _members(wanted)}
        hitting = already + [h for h in grown if not any(a & h == a for a in already)]
        if most is not None and len(hitting) > most:
            return None
    return hitting


def _members(bits: int) -> list[int]:
    return [k for k in range(bits.bit_length()) if bits >> k & 1]


def _literals(variables: int, pattern: npt.NDArray[np.uint8]) -> Literals:
    return tuple((k, int(pattern[k])) for k in _members(variables))


def _covered(literals: Literals, patterns: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
    variables = [variable for variable, _ in literals]
    out: npt.NDArray[np.bool_] = (patterns[:, variables] == [wanted for _, wanted in literals]).all(axis=1)
    return out


def _expanded(on: npt.NDArray[np.uint8], off: npt.NDArray[np.uint8]) -> set[Literals]:
    """Return several primes of every on-pattern, each by a greedy choice of literals."""
    rng = np.random.default_rng(0)
    primes: set[Literals] = set()
    for pattern in on:
        differs = off != pattern
        # a literal is dear where it excludes many other on-patterns from the term
        price = 1.0 + (on != pattern).sum(axis=0) / len(on)
        for attempt in range(_EXPANSIONS):
            noise = np.ones(len(price)) if attempt == 0 else rng.uniform(0.5, 1.5, len(price))
            primes.add(_literals(_greedy_hitting_set(differs, price * noise), pattern))
    return primes


def _greedy_hitting_set(differs: npt.NDArray[np.bool_], price: npt.NDArray[np.float64]) -> int:
    chosen: list[int] = []
    left = np.ones(len(differs), np.bool_)
    while left.any():
        best = int((differs[left].sum(axis=0) / price).argmax())
        chosen.append(best)
        left &= ~differs[:, best]
    for k in sorted(chosen, key=lambda k: (-price[k], k)):
        rest = [other for other in chosen if other != k]
        if differs[:, rest].any(axis=1).all():
            chosen = rest
    return sum(1 << k for k in chosen)


def _greedy_cover(covers: npt.NDArray[np.bool_]) -> list[int]:
    chosen: list[int] = []
    left = np.ones(covers.shape[1], np.bool_)
    while left.any():
        best = int(covers[:, left].sum(axis=1).argmax())
        chosen.append(best)
        left &= ~covers[best]
    for k in list(chosen):
        rest = [other for other in chosen if other != k]
        if rest and covers[rest].any(axis=0).all():
            chosen = rest
    return chosen


def _minimum_cover(
    covers: npt.NDArray[np.bool_], literals: list[int], greedy: list[int], *, limited: bool
) -> tuple[list[int], bool]:
    """Return the rows that cover all columns, fewest, then with the fewest literals; and whether proved."""
    rows = _undominated(covers, literals)
    table = np.unique(covers[rows], axis=1)
    # one term more must cost more than all literals that a cover no larger than the greedy one can hold
    term = sum(sorted(literals)[-len(greedy) :]) + 1
    try:
        from scipy.optimize import Bounds, LinearConstraint, milp
        from scipy.sparse import csr_array
    except ModuleNotFoundError:
        chosen, proved = _searched_cover(table, [term + literals[k] for k in rows])
        return (greedy if chosen is None else [rows[k] for k in chosen]), proved
    result = milp(
        np.array([term + literals[k] for k in rows], np.float64),
        constraints=LinearConstraint(csr_array(table.T.astype(np.float64)), 1, np.inf),
        integrality=np.ones(len(rows), np.int64),
        bounds=Bounds(0, 1),
        options={"mip_rel_gap": 0, "node_limit": _MOST_NODES if limited else 2**31 - 1},
    )
    if result.x is None:
        return greedy, False
    found = [k for k, x in zip(rows, np.rint(result.x), strict=True) if x]
    return found, result.status == 0


def _searched_cover(table: npt.NDArray[np.bool_], costs: list[int]) -> tuple[list[int] | None, bool]:
    """Return the rows that cover all columns at the least cost, by depth first; None and False where it takes long."""
    order = np.argsort(table.sum(axis=0), kind="stable")
    # One whole number a row, bit c for column c, the column that lies in fewest rows first.
    sets = [int("".join("01"[bit] for bit in row[order][::-1]), 2) for row in table.astype(np.uint8)]
    best: list[int] | None = None
    least, nodes = sum(costs) + 1, 0
    waiting: list[tuple[int, int, list[int]]] = [((1 << table.shape[1]) - 1, 0, [])]
    while waiting:
        left, cost, chosen = waiting.pop()
        nodes += 1
        if nodes > _MOST_NODES:
            return None, False
        if not left:
            if cost < least:
                best, least = chosen, cost
            continue
        first = left & -left
        more = [k for k in range(len(sets)) if sets[k] & first and cost + costs[k] < least]
        # The last is tried first: that which covers most of what is left.
        more.sort(key=lambda k: ((sets[k] & left).bit_count(), -costs[k], -k))
        waiting += [(left & ~sets[k], cost + costs[k], [*chosen, k]) for k in more]
    return best, True


def _undominated(covers: npt.NDArray[np.bool_], literals: list[int]) -> list[int]:
    """Return rows of which no other, as short, covers the same or more; the first among equals."""
    if len(covers) > 3_000:
        return list(range(len(covers)))
    sets = covers.astype(np.float32)
    common = sets @ sets.T
    size = common.diagonal()
    length = np.array(literals)
    order = np.arange(len(covers))
    inside = common == size[:, None]  # row k lies inside row j
    equal = inside & inside.T & (length[:, None] == length[None, :])
    better = inside & (length[None, :] <= length[:, None]) & (~equal | (order[None, :] < order[:, None]))
    return [int(k) for k in np.flatnonzero(~better.any(axis=1))]
