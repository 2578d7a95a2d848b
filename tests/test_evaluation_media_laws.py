"""Media of the yardstick: what is drawn for each press, when a frame is drawn again, how soon a contact is solved."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.plain_learner import press_of
from tests.test_evaluation_plain import a_press

from varishold import InputError
from varishold.evaluation import leaks
from varishold.evaluation.features import pooled_frames
from varishold.evaluation.held_out import Felt
from varishold.evaluation.running import _check_options, felt_presses
from varishold.evaluation.splits import split_presses
from varishold.evaluation.yardstick import media, solver
from varishold.evaluation.yardstick.forms import Change, Face
from varishold.touch.course.measures import learn_settings
from varishold.touch.course.presses import Press

Floats = np.ndarray[Any, np.dtype[np.float64]]


def ball(kind: str = "sphere") -> Face:
    return Face(kind, lambda x, y: (x**2 + y**2) / 20, 1.0, 8.0)


def spread_over(values: list[float], low: float, high: float) -> None:
    assert low <= min(values) < low + 0.1 * (high - low)
    assert high - 0.1 * (high - low) < max(values) <= high


@pytest.mark.parametrize("side", [16, 32])
def test_a_cover_is_drawn_from_its_ranges_and_solved_five_taxels_beyond_the_pad(
    monkeypatch: pytest.MonkeyPatch, side: int
) -> None:
    drawn: list[tuple[float, float, float]] = []
    asked: list[tuple[int, int, float]] = []
    monkeypatch.setattr(media, "layer_compliance", lambda *given: drawn.append(given) or given)
    monkeypatch.setattr(media, "_reading", lambda face, *given: asked.append((given[0], given[1], given[-1])) or None)
    for seed in range(120):
        media.pressed(ball(), side, "cover", np.random.default_rng(seed))
    spread_over([thick for _, thick, _ in drawn], 0.6, 2.0)
    spread_over([nu for _, _, nu in drawn], 0.2, 0.45)
    spread_over([deep / thick for (_, _, deep), (_, thick, _) in zip(asked, drawn, strict=True)], 0.3, 0.8)
    assert {(size, margin) for size, margin, _ in asked} == {(side, 5)}
    assert min(size for size, _, _ in drawn) >= 3 * (side + 10)


@pytest.mark.parametrize("side", [16, 32])
def test_a_half_space_is_read_at_its_depth_and_wider_for_what_is_endless(
    monkeypatch: pytest.MonkeyPatch, side: int
) -> None:
    asked: list[tuple[int, int, Any, int, float]] = []
    sizes: list[tuple[int, int]] = []
    monkeypatch.setattr(media, "half_space_response", lambda size, n: sizes.append((size, n)) or size)
    monkeypatch.setattr(media, "_reading", lambda face, *given: asked.append(given) or None)
    for seed in range(120):
        media.pressed(ball(), side, "half-space", np.random.default_rng(seed))
    spread_over([given[-1] for given in asked], 0.4 * side / 32, side / 32)
    assert {given[:2] for given in asked} == {(side, 8)}
    asked.clear()
    for kind in ("edge", "plane"):
        media.half_space_reading(ball(kind), side, 0.7)
    assert [(given[1], given[-1]) for given in asked] == [(side // 2, 0.7)] * 2
    for size, n in sizes:
        assert n in (3 * (side + 16), 3 * (side + 2 * (side // 2)))
        # A load at one end must not come round to the other.
        assert size >= 2 * n


@pytest.mark.parametrize(("side", "least"), [(16, 11), (32, 24)])
@pytest.mark.parametrize("cut", [0.0, 0.5])
def test_a_frame_of_too_few_taxels_is_drawn_again(
    monkeypatch: pytest.MonkeyPatch, side: int, least: int, cut: float
) -> None:
    seeds: list[tuple[int, ...]] = []

    def faces(seed: tuple[int, ...], kind: str, index: int, side: int, change: Change, grow: float) -> Face | None:
        seeds.append(seed)
        assert (index, change.cut, grow) == (4, cut, 1.0)
        return None if len(seeds) == 1 else ball(kind)

    def frame(face: Face, side: int) -> Floats:
        """One taxel more each time, beside some that hold a tenth of the peak and no more."""
        made = np.zeros(side * side)
        made[-40:] = 0.5
        made[0] = 5.0
        made[1 : len(seeds) - 1] = 0.51
        return made.reshape(side, side)

    monkeypatch.setattr(media, "draw_face", faces)
    monkeypatch.setattr(media, "height_map", frame)
    found = media._draw("ideal", side, Change(cut=cut), (1, 2), "cone", 4)
    wanted = int(np.ceil(least * (1 - cut)))
    assert (found > 0.1).sum() == wanted
    assert found.max() == 1
    assert seeds == [(1, 2, attempt) for attempt in range(wanted + 1)]
    seeds.clear()
    assert (media._draw("ideal", side, Change(cut=cut), (1,), "edge", 4) > 0.1).sum() == side
    monkeypatch.setattr(media, "draw_face", lambda *_: None)
    with pytest.raises(RuntimeError, match="no cone fits on"):
        media._draw("ideal", side, Change(cut=cut), (1,), "cone", 4)


@pytest.mark.parametrize("medium", ["layer", "half-space"])
def test_a_contact_is_solved_in_few_steps(monkeypatch: pytest.MonkeyPatch, medium: str) -> None:
    n = 48
    y, x = (np.mgrid[:n, :n] - n / 2) / solver.CELLS
    size = n if medium == "layer" else 2 * n
    spectrum = solver.layer_compliance(n, 1.2, 0.4) if medium == "layer" else solver.half_space_response(size, n)
    turns: list[int] = []
    real = solver.fft

    def counted(*given: Any) -> Any:
        turns.append(1)
        return real.irfft2(*given)

    monkeypatch.setattr(solver, "fft", SimpleNamespace(irfft2=counted, rfft2=real.rfft2))
    steps = []
    for shape in (1.0 - 0.05 * (x**2 + y**2), np.where(np.hypot(x, y) < 5, 1.0, -1.0), 1.0 - 0.2 * abs(x)):
        turns.clear()
        p = solver.solve(shape, spectrum, size)
        # Two a step, and one for the start.
        assert len(turns) % 2 == 0
        steps.append(len(turns) // 2)
        lifted = real.irfft2(real.rfft2(p, (size, size)) * spectrum, (size, size))[:n, :n]
        off = np.sqrt(((lifted - shape)[p > 0] ** 2).mean())
        assert off < 3e-4 * shape.max()
        assert (lifted - shape)[(shape > 0) & (p == 0)].min(initial=0) > -3e-4 * shape.max()
    # A ball, a punch and a wedge. Without conjugate ways they would need many times as many.
    assert all(n <= most for n, most in zip(steps, (5, 8, 6) if medium == "layer" else (10, 10, 25), strict=True))


# ---- what leaks are looked for in


def test_taxels_away_from_all_training_presses_are_those_of_plain_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[Any] = []
    monkeypatch.setattr(leaks, "_told_by", lambda name, says, features, *rest: kept.append(features))
    rng = np.random.default_rng(0)
    field = np.ones((9, 10), bool)
    field[8, 9] = False
    presses = []
    for k in range(12):
        frames = rng.normal(0, 0.01, (4, 9, 10))
        frames[1:, 2 : 4 + k % 2, 3:5] += 5.0 + k
        frames[1:, 6, 7] += 0.11 * (5.0 + k) if k == 11 else 0.0
        presses.append(Press({"pad": frames}, {"pad": field}))
    codes = np.tile([0, 1], 6)
    felt = Felt(presses, codes, np.array(["a", "b"]), np.repeat(["x", "y", "z"], 4))
    leaks._told_by_untouched(felt, split_presses(felt.classes[codes], felt.groups), 0)
    for train in (np.arange(12), np.arange(8)):
        settings = learn_settings([presses[k] for k in train], position=True, absolute=True)
        pooled = pooled_frames(presses, settings.shapes, settings.floor)["pad"]
        peaks = sorted(float(pooled[k].max()) for k in train)
        limit = max(settings.floor, 0.1 * float(np.quantile(peaks, 0.9)))
        away = []
        for r, c in np.ndindex(9, 10):
            near = pooled[train][:, max(0, r - 2) : r + 3, max(0, c - 2) : c + 3]
            if field[r, c] and not (abs(near) > limit).any():
                away.append((r, c))
        table = kept[0](train)
        assert table.shape == (12, len(away))
        assert table == pytest.approx(np.array([[pooled[k][place] for place in away] for k in range(12)]))
    assert kept[0](np.arange(8)).shape != kept[0](np.arange(12)).shape


def test_joints_that_stand_still_are_asked_with_what_is_unknown_at_their_mean(monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[Any] = []
    monkeypatch.setattr(leaks, "_told_by", lambda name, says, features, *rest: kept.append((says, features)))
    rng = np.random.default_rng(0)
    values = [(1.0 + 1e-5 * k if k % 3 else np.nan, float(rng.normal()), float(k)) for k in range(8)]
    presses = [
        press_of(k, **{"angle_rad.b": b, "angle_rad.a": a, "force_n.z": z}) for k, (b, a, z) in enumerate(values)
    ]
    felt = Felt(presses, np.tile([0, 1], 4), np.array(["a", "b"]), np.repeat(["x", "y"], 4))
    split = split_presses(felt.classes[felt.codes], felt.groups)
    leaks._told_by_still(felt, split, 0)
    ((says, features),) = kept
    assert says.startswith("joints that stand still (angle_rad.b) tell the thing in {share}")
    mean = np.mean([b for b, _, _ in values if np.isfinite(b)])
    assert features(np.arange(4)).tolist() == [[b if np.isfinite(b) else pytest.approx(mean)] for b, _, _ in values]
    kept.clear()
    bare = Felt([press_of(k, **{"force_n.z": 1.0}) for k in range(8)], felt.codes, felt.classes, felt.groups)
    assert leaks._told_by_still(bare, split, 0) is None
    assert kept == []


# ---- what is given


def test_presses_labels_and_groups_are_taken_as_they_are_and_told_where_they_are_wrong() -> None:
    presses = [press_of(k, f"press {k}") for k in range(4)]
    felt = felt_presses(presses, [3, 1, 3, 1], [True, True, False, False])
    assert felt.classes.tolist() == ["1", "3"]
    assert felt.codes.tolist() == [1, 0, 1, 0]
    assert felt.groups is not None
    assert felt.groups.tolist() == ["True", "True", "False", "False"]
    assert felt_presses(presses, list("abab"), None).groups is None
    flat = felt_presses(np.arange(24.0).reshape(4, 6), list("abab"), None, (2, 3))
    assert [press.shapes for press in flat.presses] == [{"pad_0": (2, 3)}] * 4
    other = [*presses[:3], a_press(np.ones((1, 3, 3)))]
    for X, y, groups, told in (
        (other, "abab", None, "give presses of one sensor"),
        (presses, "aba", None, r"y must be one a press, 4 of them, got shape \(3,\)"),
        (presses, "abab", "ab", r"groups must be one a press, 4 of them, got shape \(2,\)"),
        (presses, "ab b", None, "press 2 has no label; fill it in, or leave the press out"),
        (presses, "abab", "xx x", "press 2 has no group"),
        ([], "", None, "there is no press to be tested on"),
    ):
        with pytest.raises(InputError, match=told):
            felt_presses(X, list(y), None if groups is None else list(groups))


def test_options_are_whole_numbers() -> None:
    _check_options((), 0, 1)
    _check_options((1, np.int64(20)), np.int32(7), np.int64(2))  # type: ignore[arg-type]
    for shots in ((True,), (2.0,), (0,), (1, -1), ("1",)):
        with pytest.raises(InputError, match="at least 1, got " + repr(shots[-1]).replace("(", r"\(")):
            _check_options(shots, 0, 1)  # type: ignore[arg-type]
    for seed in (True, -1, 1.0, None):
        with pytest.raises(InputError, match=f"from 0 to 4294967295, got {seed!r}"):
            _check_options((), seed, 1)  # type: ignore[arg-type]
