"""How the exact fit goes about it: steps of Levenberg and Marquardt, which fits stand, and which are refined."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.test_touch_exact_laws import FORMS, KEYS, TRUE, a_fit, seen_of

from varishold.touch.exact import FITTED, recognition
from varishold.touch.exact import fit as fitting
from varishold.touch.exact.fit import Fit
from varishold.touch.exact.slopes import parameters


def shown(form: Any) -> tuple[Any, np.ndarray]:
    seen = seen_of()
    q = np.array([TRUE[name] for name in form.names])
    made = seen.synthesis.frame(form.face(q, seen.grid), start=seen.active).frame
    return replace(seen, frame=0.7 * made / made.max()), q


def test_a_fit_takes_few_steps() -> None:
    """Half a taxel off, four or five bring what a form made down to rounding."""
    taken = {}
    for form in FORMS:
        if not form.names or type(form).__name__ == "SteepCap":
            continue
        seen, q = shown(form)
        off = np.array([{"yaw": 0.12, "top_share": 0.08}.get(name, 0.5) for name in form.names])
        found = fitting.fit_form(form, q + off, seen)
        assert found is not None
        assert found.chi2 < 1e-3
        taken[type(form).__name__] = found.steps
    assert max(taken.values()) <= 5
    assert sum(taken.values()) <= 56


@pytest.mark.parametrize(("key", "steps"), [("cylinder", 3), ("cone-frustum", 5), ("ridge", 4), ("edge", 4)])
def test_a_refinement_takes_few_steps(key: str, steps: int) -> None:
    seen, form = seen_of(), FITTED[key][0]
    q = np.array([TRUE[name] for name in form.names])
    fine = seen.fine.sensed(seen.fine.pressure(form.face(q, seen.fine_grid), start=np.zeros(seen.fine_grid.x.size)))
    seen = replace(seen, frame=fine / fine.max())
    rough = fitting.fit_form(form, q + 0.3, seen)
    assert rough is not None
    better = fitting.refine(rough, seen)
    assert better.steps - rough.steps <= steps
    assert better.chi2 < 0.25
    if key == "cylinder":
        lost = replace(rough, q=rough.q + 100.0)
        assert fitting.refine(lost, seen) is lost


class Valley:
    """A form whose model is a known function of one parameter, so that each step can be foretold."""

    names = ("x",)
    key = "edge"


def test_a_step_is_damped_more_after_a_failure_and_less_after_a_success(monkeypatch: pytest.MonkeyPatch) -> None:
    """From .001: after a failure thirty times as much, a hundredth at least; a tenth after a success."""
    asked: list[float] = []
    chi2s: list[float] = []

    def tried(form: Any, q: Any, seen: Any, active: Any) -> Any:
        return fitting._Tried(np.asarray(q, float), SimpleNamespace(active=None), None, 1.0, None, chi2s.pop(0))  # type: ignore[arg-type]

    def step(form: Any, now: Any, seen: Any, damping: float) -> np.ndarray:
        asked.append(damping)
        return np.array([0.1])

    monkeypatch.setattr(fitting, "_try", tried)
    monkeypatch.setattr(fitting, "_step", step)
    seen: Any = SimpleNamespace(active=np.ones(3, bool), count=50, synthesis=SimpleNamespace(shape=(9, 9)))

    def went(*values: float, **how: Any) -> Fit:
        asked.clear()
        chi2s[:] = values
        found = fitting.fit_form(Valley(), np.zeros(1), seen, **how)  # type: ignore[arg-type]
        assert found is not None
        return found

    # Failures: given up once the damping passes ten.
    assert went(100.0, 120.0, 100.0, 130.0, 140.0, 150.0).steps == 3
    assert asked == pytest.approx([1e-3, 0.03, 0.9])
    # Successes: each a tenth; ended by what decides nothing, a share of chi^2 or .3.
    assert went(1000.0, 900.0, 800.0, 798.5).steps == 3
    assert asked == pytest.approx([1e-3, 1e-4, 1e-5])
    assert went(10.0, 9.0, 8.75).steps == 2
    assert went(10.0, 9.0, 8.65, 8.64).steps == 3
    assert went(1000.0, 900.0, 1000.0, 899.0).steps == 3
    assert asked == pytest.approx([1e-3, 1e-4, 0.01])
    # No more steps than are allowed, eight by default; no better than before is a failure.
    assert went(*(1000.0 * 0.8**k for k in range(12))).steps == 8
    assert went(*(1000.0 * 0.8**k for k in range(12)), most_steps=3).steps == 3
    assert went(5.0, 5.0, 1.0, 0.9, 0.85).q[0] == pytest.approx(0.2)
    # Behind another form by more than a factor of eight it is given up after three steps.
    assert went(*(1000.0 * 0.8**k for k in range(12)), rival=1000 * 0.8**3 / 8.1).steps == 3
    assert went(*(1000.0 * 0.8**k for k in range(12)), rival=1000 * 0.8**3 / 7.9).steps == 8
    # The best chi^2 is kept, and its cost counts the parameters.
    found = went(100.0, 60.0, 70.0, 59.9)
    assert found.chi2 == 59.9
    assert found.cost == pytest.approx(59.9 + math.log(50))


def test_a_refinement_is_damped_alike_and_ends_sooner(monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure counts thirty times, a tenth at least; five steps at most, or until less than .3 is gained."""
    asked: list[float] = []
    chi2s: list[float] = []
    starts: list[float] = []

    def tried(q: Any, chi2: float) -> Any:
        made = SimpleNamespace(active=None, pressure="coarse")
        return fitting._Tried(np.asarray(q, float), made, None, 1.0, None, chi2)  # type: ignore[arg-type]

    def finely(form: Any, q: Any, made: Any, seen: Any, start: Any) -> Any:
        starts.append(start)
        return tried(q, chi2s.pop(0)), len(starts)

    def step(form: Any, now: Any, seen: Any, damping: float) -> np.ndarray:
        asked.append(damping)
        return np.array([0.1])

    monkeypatch.setattr(fitting, "_try", lambda form, q, seen, active: tried(q, 500.0))
    monkeypatch.setattr(fitting, "_try_finely", finely)
    monkeypatch.setattr(fitting, "_halved", lambda pressure, seen: f"halved {pressure}")
    monkeypatch.setattr(fitting, "_step", step)
    seen: Any = SimpleNamespace(active=np.ones(3, bool), count=50, synthesis=SimpleNamespace(shape=(9, 9)))
    begun = fitting.Fit(Valley(), np.zeros(1), 1.0, 500.0, 504.0, 3, np.ones(1, bool))  # type: ignore[arg-type]

    def went(*values: float) -> Fit:
        asked.clear()
        starts.clear()
        chi2s[:] = values
        return fitting.refine(begun, seen)

    assert went(100.0, 120.0, 100.0, 99.0, 98.0, 97.0, 0.0).steps == 3 + 5
    assert asked == pytest.approx([1e-3, 0.1, 3.0, 0.3, 0.03])
    # Each pressure begins with the last one.
    assert starts == ["halved coarse", 1, 2, 3, 4, 5]
    done = went(100.0, 90.0, 89.75)
    assert (done.steps, done.chi2) == (3 + 2, 89.75)
    assert asked == pytest.approx([1e-3, 1e-4])
    assert went(100.0, 90.0, 89.65, 89.6).steps == 3 + 3
    assert done.q[0] == pytest.approx(0.2)
    assert went(10.0, 12.0, 11.0, 11.0, 11.0, 11.0).chi2 == 10.0


def test_a_step_solves_the_damped_normal_equations_without_the_gain() -> None:
    form = FITTED["rectangular-pillar"][0]
    seen, q = shown(form)
    now = fitting._try(form, q + 0.2, seen, seen.active)
    assert now is not None
    slope = (now.gain * now.made.gradient * seen.weight).reshape(len(q), -1)
    model = (now.made.frame * seen.weight).ravel()
    slope = slope - np.outer(slope @ model / (model @ model), model)
    normal = slope @ slope.T
    for damping in (1e-3, 0.5):
        told = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope @ now.residual.ravel())
        longest = np.array([0.35 if name == "yaw" else 1.5 for name in form.names])
        told = told / max(np.abs(told / longest).max(), 1.0)
        np.testing.assert_allclose(fitting._step(form, now, seen, damping), told, rtol=1e-6)


def test_of_two_ways_to_fit_a_kind_the_better_counts_if_its_borders_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, float]] = []
    answers: dict[str, Fit | None] = {}

    def fit_form(form: Any, start: Any, seen: Any, *, rival: float) -> Fit | None:
        asked.append((type(form).__name__, rival))
        return answers.get(type(form).__name__)

    monkeypatch.setattr(recognition, "fit_form", fit_form)
    monkeypatch.setattr(recognition, "_refined", lambda found, seen: found)
    monkeypatch.setattr(recognition, "_stands", lambda fit, seen: fit.chi2 != 77.0)
    p = np.zeros(len(KEYS))
    for share, key in ((0.5, "lying-cylinder"), (0.3, "cylinder")):
        p[KEYS.index(key)] = share
    seen = SimpleNamespace(active=np.ones(5, bool), count=30)
    start = SimpleNamespace(
        x=0.0, y=0.0, long=5.0, short=4.0, yaw=0.1, square_yaw=0.2, descent=0.0, crest=0.0, breadth=4.5
    )
    answers |= {"Arch": a_fit("lying-cylinder", 90.0), "EndlessArch": a_fit("lying-cylinder", 60.0), "Disc": None}
    found = recognition._fits(p, seen, start)  # type: ignore[arg-type]
    assert {key: fit.chi2 for key, fit in found.items()} == {"lying-cylinder": 60.0}
    assert asked == [("Arch", math.inf), ("EndlessArch", 90.0), ("Disc", 60.0)]
    asked.clear()
    answers |= {"EndlessArch": a_fit("lying-cylinder", 95.0), "Disc": a_fit("cylinder", 20.0)}
    found = recognition._fits(p, seen, start)  # type: ignore[arg-type]
    assert {key: fit.chi2 for key, fit in found.items()} == {"lying-cylinder": 90.0, "cylinder": 20.0}
    # What is better than the noise is no rival; what does not stand is no fit.
    answers |= {"Arch": a_fit("lying-cylinder", 10.0), "Disc": a_fit("cylinder", 77.0)}
    asked.clear()
    assert list(recognition._fits(p, seen, start)) == ["lying-cylinder"]  # type: ignore[arg-type]
    assert [rival for _, rival in asked] == [math.inf, 30.0, 30.0]


def test_a_fit_stands_where_its_form_is_possible_in_the_window() -> None:
    asked: list[Any] = []
    form = SimpleNamespace(possible=lambda *what: asked.append(what) or "told")
    seen = seen_of(14, 12)
    q = np.zeros(2)
    assert recognition._stands(SimpleNamespace(form=form, q=q), seen) == "told"  # type: ignore[arg-type,comparison-overlap]
    ((given, width, height),) = asked
    assert given is q
    assert (width, height) == pytest.approx((12.0, 14.0))


def test_fits_within_reach_of_the_best_are_refined_if_there_is_a_choice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recognition, "refine", lambda fit, seen: replace(fit, cost=fit.cost - 50.0, steps=99))
    seen: Any = SimpleNamespace(count=20)

    def refined(**chi2: float) -> list[str]:
        found = {key.replace("_", "-"): a_fit(key.replace("_", "-"), value) for key, value in chi2.items()}
        out = recognition._refined(found, seen)
        costs = [fit.cost for fit in out.values()]
        assert costs == sorted(costs)
        return sorted(key for key, fit in out.items() if fit.steps == 99)

    assert refined(cone=40.0, sphere=119.0, ridge=121.0) == ["cone", "sphere"]
    # Below the noise the noise counts.
    assert refined(cone=5.0, sphere=59.0, ridge=61.0) == ["cone", "sphere"]
    assert refined(cone=40.0, ridge=121.0) == []
    assert refined(cone=40.0) == []
    assert refined() == []
    assert refined(cone=40.0, sphere=41.0, ridge=42.0, hip=43.0) == ["cone", "ridge", "sphere"]


def test_an_endless_face_covers_every_cell_and_depends_on_nothing() -> None:
    seen = seen_of()
    face = FITTED["plane"][0].face(np.zeros(0), seen.grid)
    assert (face.covered == 1).all()
    assert (face.wanted == 1).all()
    assert face.d_wanted.shape == face.d_covered.shape == (0, seen.grid.x.size)
    assert parameters(np.zeros(0)) == ()
