"""Speed of the packed evaluator against scikit-learn's predictors on 22 switches, one thread, interleaved.

Three circuits: a random one, and what `HyperplaneClassifier("robust")` makes of ten generated grasps of each of two
objects (`benchmarks.planar_grasps`): of 30 seeds the one with the median number of gates, and the one with most.

Run with ``python -m benchmarks.circuit_speed``. Every round takes the contenders in random order, each
warmed by one call and then called for about 10 ms (the slow ones once); a figure is the median over the
rounds of the CPU time a call. Each peer reads the input that suits it best (of float64 in C and Fortran
order, float32 and uint8). "Packed" reads words and writes a class index a grasp;
"packed, with packing" starts from a boolean array. Other work on the machine moves the ratios: the load average is
printed beside them.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np

from benchmarks._figures import figure
from benchmarks.planar_grasps import SHAPES, planar_grasps
from varishold.circuit import Hyperplane, Netlist, PackedEvaluator, Score, Term, evaluate, gate_count, pack
from varishold.grasp import HyperplaneClassifier

SWITCHES = 22
GRASPS = 100_000
ROUNDS = 41
STEADY_S = 0.01
SEEDS = 30
TRAINING_GRASPS = 10
# Generated grasps of each object; the GRASPS that are timed are drawn from them.
DISTINCT_GRASPS = 2000


def robust_netlist(seed: int, *, hyperplanes: int = 12, switches_each: int = 9, terms: int = 8) -> Netlist:
    """Make a netlist of the size that a robust two-class grasp classifier has."""
    rng = np.random.default_rng(seed)
    patterns = rng.integers(0, 2, (2, SWITCHES))
    units = []
    while len(units) < hyperplanes:
        first, second = (pattern ^ (rng.random(SWITCHES) < 0.12) for pattern in patterns)
        differing = np.flatnonzero(first != second)
        if len(differing) < switches_each:
            patterns[1, rng.integers(SWITCHES)] ^= 1
            continue
        kept = np.isin(np.arange(SWITCHES), rng.permutation(differing)[:switches_each])
        units.append(Hyperplane.between((first * kept).tolist(), (second * kept).tolist()))
    products = [Term([(int(unit), 1) for unit in rng.choice(hyperplanes, 3, replace=False)]) for _ in range(terms)]
    return Netlist(
        channels=tuple(f"switch {k}" for k in range(SWITCHES)),
        comparators=(),
        units=tuple(units),
        terms=tuple(products),
        scores=(Score([], 1), Score([(t, 2) for t in range(terms)])),
        classes=("pillar", "cylinder"),
    )


def fitted_robust() -> list[tuple[Netlist, np.ndarray, np.ndarray]]:
    """Fit ``robust`` on ten grasps of each of two objects, every seed.

    Returns netlist, training grasps and their class indices of each, by rising number of gates.
    """
    fits = []
    for seed in range(SEEDS):
        X, y = planar_grasps(SHAPES[:2], TRAINING_GRASPS, np.random.default_rng(seed))
        fitted = HyperplaneClassifier("robust").fit(X, y)
        fits.append((fitted.netlist_, X, np.searchsorted(fitted.classes_, y)))
    return sorted(fits, key=lambda fit: gate_count(fit[0]))


def peers(X: np.ndarray, y: np.ndarray, grasps: np.ndarray) -> dict[str, Callable[[], object]]:
    """Fit scikit-learn's predictors on `X` and give each the copy of `grasps` that it reads fastest."""
    from sklearn.ensemble import ExtraTreesClassifier, RandomForestClassifier
    from sklearn.linear_model import LogisticRegression
    from sklearn.naive_bayes import BernoulliNB
    from sklearn.neighbors import KNeighborsClassifier
    from sklearn.svm import SVC, LinearSVC
    from sklearn.tree import DecisionTreeClassifier

    copies = [
        grasps.astype(np.float64),
        np.asfortranarray(grasps, np.float64),
        grasps.astype(np.float32),
        grasps.astype(np.uint8),
    ]
    models = {
        "LogisticRegression": LogisticRegression(),
        "LinearSVC": LinearSVC(),
        "DecisionTreeClassifier": DecisionTreeClassifier(random_state=0),
        "BernoulliNB": BernoulliNB(),
        "SVC, rbf": SVC(),
        "RandomForestClassifier": RandomForestClassifier(random_state=0),
        "ExtraTreesClassifier": ExtraTreesClassifier(random_state=0),
        "KNeighborsClassifier(1, brute)": KNeighborsClassifier(1, algorithm="brute"),
        "KNeighborsClassifier(1, kd_tree)": KNeighborsClassifier(1, algorithm="kd_tree"),
    }
    out: dict[str, Callable[[], object]] = {}
    for name, model in models.items():
        model.fit(X.astype(np.float64), y)
        best = min(copies, key=lambda Z, predict=model.predict: min(_timed(lambda: predict(Z)) for _ in range(3)))
        out[name] = lambda predict=model.predict, Z=best: predict(Z)
    return out


def _timed(run: Callable[[], object]) -> float:
    start = time.process_time_ns()
    run()
    return (time.process_time_ns() - start) * 1e-9


def _steady(run: Callable[[], object]) -> float:
    """Return the time a call takes once its data are as near as they get, over about 10 ms of calls."""
    first = _timed(run)
    if first > STEADY_S:
        return first
    second = _timed(run)
    calls = max(1, round(STEADY_S / max(second, 1e-6)))

    def repeat() -> None:
        for _ in range(calls):
            run()

    return _timed(repeat) / calls


def main() -> None:
    """Print the time of every contender and the ratios."""
    from threadpoolctl import threadpool_limits

    rng = np.random.default_rng(0)
    generated = robust_netlist(0)
    grasps = rng.integers(0, 2, (GRASPS, SWITCHES)).astype(np.bool_)
    labels = evaluate(generated, grasps)
    training = np.concatenate([np.flatnonzero(labels == c)[:TRAINING_GRASPS] for c in (0, 1)])
    fits = fitted_robust()
    rng = np.random.default_rng(SEEDS)
    felt, _ = planar_grasps(SHAPES[:2], DISTINCT_GRASPS, rng)
    felt = felt[rng.integers(len(felt), size=GRASPS)]
    with threadpool_limits(1):
        _compare("random circuit", generated, grasps[training], labels[training], grasps)
        _compare(f"fitted robust circuit, median of {SEEDS} seeds", *fits[SEEDS // 2], felt)
        _compare(f"fitted robust circuit, largest of {SEEDS} seeds", *fits[-1], felt)


def _compare(title: str, netlist: Netlist, X: np.ndarray, y: np.ndarray, grasps: np.ndarray) -> None:
    """Time the netlist and peers fitted on (X, y) over `grasps`, and print the ratios."""
    rng = np.random.default_rng(0)
    load_before = os.getloadavg()[0]
    evaluator = PackedEvaluator(netlist)
    packed = pack(grasps)
    assert np.array_equal(evaluator.predict(packed), evaluate(netlist, grasps))

    contenders = peers(X, y, grasps)
    ours = {
        "packed": lambda: evaluator.predict(packed),
        "packed, class planes only": lambda: evaluator.class_planes(packed),
        "packed, with packing": lambda: evaluator.predict(evaluator.pack(grasps)),
        "evaluate (reference)": lambda: evaluate(netlist, grasps),
    }
    slow = {name for name, run in contenders.items() if _timed(run) > 0.05}
    times: dict[str, list[float]] = {name: [] for name in [*ours, *contenders]}
    for round_ in range(ROUNDS):
        names = [name for name in times if round_ < 3 or name not in slow]
        for name in rng.permutation(names):
            times[name].append(_steady((ours | contenders)[name]))
    median = {name: float(np.median(values)) for name, values in times.items()}

    print(
        f"{title}: {GRASPS} grasps, {SWITCHES} switches, {len(netlist.units)} hyperplanes of "
        f"{np.mean([len(unit.weights) for unit in netlist.units]):.1f} switches, {len(netlist.terms)} terms, "
        f"{gate_count(netlist)} two-input gates; CPU time, median of {ROUNDS} interleaved rounds; "
        f"load average {load_before:.1f} before, {os.getloadavg()[0]:.1f} after"
    )
    for name, value in sorted(median.items(), key=lambda item: item[1]):
        grasp = figure(f"{title}: {name}", value / GRASPS * 1e9, "9.2f", "ns a grasp")
        print(f"{name:34s} {value * 1e6:12.1f} us {grasp}")
    fastest = min(contenders, key=median.__getitem__)
    nearest = min((name for name in contenders if name.startswith("KN")), key=median.__getitem__)
    for name in list(ours)[:3]:
        ratio = figure(f"{title}: {name}, against the fastest peer", median[fastest] / median[name], ".0f", "times")
        print(f"{name}: {ratio} {fastest}, {median[nearest] / median[name]:.0f} times {nearest}")


if __name__ == "__main__":
    main()
