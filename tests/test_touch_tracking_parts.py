"""The parts of the tracker, each against a slow reference or by what is said of it."""

from __future__ import annotations

import math
from itertools import permutations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.levelset.contact import with_losses
from varishold.touch import find_contacts
from varishold.touch.tracking import evidence
from varishold.touch.tracking.assignment import assign
from varishold.touch.tracking.change import Rest
from varishold.touch.tracking.evidence import Evidence
from varishold.touch.tracking.felt import Felt, feel, gap, joined
from varishold.touch.tracking.motion import Motion, Told
from varishold.touch.tracking.noise import Noise
from varishold.touch.tracking.recent import Recent
from varishold.touch.tracking.steady_mean import SteadyMean
from varishold.touch.tracking.touch import Touch

SIDE = 16
STEP_S = 0.005
points = st.tuples(st.floats(-8, 8), st.floats(-8, 8))


def bump(x: float, y: float, peak: float = 1000.0, reach: float = 4.0, stretch: float = 1.0) -> np.ndarray:
    """Return a smooth heap of pressure; (x, y) from the pad's centre."""
    rows, cols = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    return np.asarray(peak * np.exp(-(((cols - x) / stretch) ** 2 + (rows - y) ** 2) / reach))


def felt_of(frame: np.ndarray, sigma: float = 1.0) -> Felt:
    """Return the only contact of a frame."""
    (felt,) = feel(find_contacts(frame, sigma=sigma), sigma)
    return felt


# What is remembered of the last moments.

moments = st.lists(st.tuples(st.integers(1, 12), points, st.floats(1, 100)), min_size=1, max_size=60)


@given(moments, st.integers(1, 40))
@settings(max_examples=200)
def test_the_last_moments_are_those_of_the_whole_course(course: list[tuple[int, Any, float]], ago: int) -> None:
    """Of all that came, with ages in whole steps, nothing that was forgotten mattered."""
    recent, seen, at = Recent(40 * STEP_S), [], 0
    for step, position, load in course:
        at += step
        seen.append((at, position, load))
        recent.add(at * STEP_S, SimpleNamespace(position=position, load=load))  # type: ignore[arg-type]
    ages = [at - then for then, _, _ in seen]
    loads = [load for _, _, load in seen]
    old = [load for age, load in zip(ages, loads, strict=True) if age >= ago]
    assert recent.reaches(ago * STEP_S) == bool(old)
    assert recent.step_s == pytest.approx(course[-1][0] * STEP_S if len(course) > 1 else 0.0)
    if not old:
        return
    assert recent.load_change(ago * STEP_S) == pytest.approx(abs(old[-1] - loads[-1]) / loads[-1])
    since = [load for age, load in zip(ages, loads, strict=True) if age <= ago]
    assert recent.load_range(ago * STEP_S) == pytest.approx(
        max(abs(load - loads[-1]) for load in [*since, old[-1]]) / loads[-1]
    )
    # Between two steps, so that no frame stands on the border of a half.
    half = [[p for (_, p, _), a in zip(seen, ages, strict=True) if low <= a < high] for low, high in halves(ago)]
    drift = recent.drift((ago - 0.3) * STEP_S)
    if all(half):
        assert drift == pytest.approx(math.dist(np.mean(half[0], axis=0), np.mean(half[1], axis=0)))
    else:
        assert drift == math.inf


def halves(ago: int) -> tuple[tuple[float, float], tuple[float, float]]:
    return ((ago - 0.3) / 2, ago - 0.3), (0, (ago - 0.3) / 2)


# Which contact is which touch.

places = st.lists(st.integers(0, 35), min_size=1, max_size=6, unique=True)
things = st.lists(st.tuples(places, points), max_size=4)


def disjoint(drawn: list[tuple[list[int], Any]]) -> list[tuple[list[int], Any]]:
    """Leave every taxel to the first that has it."""
    taken: set[int] = set()
    out = []
    for taxels, point in drawn:
        left = [taxel for taxel in taxels if taxel not in taken]
        taken |= set(left)
        if left:
            out.append((left, point))
    return out


@given(things, things, st.floats(0.1, 6))
@settings(max_examples=400)
def test_touches_and_contacts_are_paired_as_a_plain_search_pairs_them(
    before: list[tuple[list[int], Any]], now: list[tuple[list[int], Any]], reach: float
) -> None:
    now = disjoint(now)
    touches: Any = [SimpleNamespace(taxels=np.array(t), expected=p, reach=reach) for t, p in before]
    contact = SimpleNamespace(shape=(6, 6))
    felt: Any = [SimpleNamespace(taxels=np.array(t), position=p, contact=contact) for t, p in now]
    found = assign(touches, felt)
    shared = [[len(set(t) & set(its)) for its, _ in now] for t, _ in before]
    far = [[math.dist(p, its) for _, its in now] for _, p in before]
    # Every contact has one meaning, every touch one at most.
    meanings = [*found.pairs.values(), *found.fragments, *found.new]
    assert sorted(meanings) == list(range(len(now)))
    assert not set(found.pairs) & set(found.merged)
    for i, k in found.pairs.items():
        assert shared[i][k] > 0 or far[i][k] <= reach
    for i, k in found.merged.items():
        assert shared[i][k] == max(shared[i])
        assert 2 * shared[i][k] >= len(before[i][0])
        assert k in found.pairs.values() or k in found.fragments
    for k, i in found.fragments.items():
        assert shared[i][k] == max(row[k] for row in shared) > 0
    for k in found.new:
        assert not any(row[k] for row in shared)
        assert not any(far[i][k] <= reach for i in range(len(before)) if i not in found.pairs and not any(shared[i]))
    for rows, cols in groups(shared):
        chosen = {(i, k) for i, k in found.pairs.items() if i in rows and k in cols}
        if min(len(rows), len(cols)) > 1:
            best = least(rows, cols, far)
            assert chosen == {(i, k) for i, k in best if shared[i][k] or far[i][k] <= reach}
        else:
            ((i, k),) = chosen
            assert shared[i][k] == max(shared[a][b] for a in rows for b in cols)


def least(rows: list[int], cols: list[int], far: list[list[float]]) -> list[tuple[int, int]]:
    """Return the pairs of least total distance."""
    few, many = sorted((rows, cols), key=len)
    ways = [list(zip(few, those, strict=False)) for those in permutations(many, len(few))]
    if few is not rows:
        ways = [[(i, k) for k, i in way] for way in ways]
    return min(ways, key=lambda way: sum(far[i][k] for i, k in way))


def groups(shared: list[list[int]]) -> list[tuple[list[int], list[int]]]:
    """Return what hangs together by overlaps, touches and contacts."""
    found: list[tuple[set[int], set[int]]] = []
    for i, row in enumerate(shared):
        mine = ({i}, {k for k, n in enumerate(row) if n})
        if not mine[1]:
            continue
        apart = [one for one in found if not one[1] & mine[1]]
        for one in found:
            if one[1] & mine[1]:
                mine = (mine[0] | one[0], mine[1] | one[1])
        found = [*apart, mine]
    return [(sorted(rows), sorted(cols)) for rows, cols in found]


def test_of_many_that_hang_together_each_has_the_nearest() -> None:
    """Seven touches over seven contacts: too many to try all ways."""
    every = np.arange(36)
    touches: Any = [SimpleNamespace(taxels=every, expected=(float(k), 0.0), reach=1.0) for k in range(7)]
    contact = SimpleNamespace(shape=(6, 6))
    order = [3, 0, 6, 2, 5, 1, 4]
    felt: Any = [
        SimpleNamespace(taxels=every[5 * j : 5 * j + 5], position=(k + 0.2, 0.0), contact=contact)
        for j, k in enumerate(order)
    ]
    assert assign(touches, felt).pairs == {k: j for j, k in enumerate(order)}


# What is taken of a contact.


@given(st.integers(0, 2**32 - 1), st.floats(0, 60))
@settings(max_examples=40)
def test_a_contact_is_felt_as_plain_sums_feel_it(seed: int, sigma: float) -> None:
    rng = np.random.default_rng(seed)
    frame = bump(*rng.uniform(-5, 5, 2)) + bump(*rng.uniform(-5, 5, 2)) + rng.normal(0, 5, (SIDE, SIDE))
    contacts = find_contacts(frame)
    felt, sigma = feel(contacts, sigma), max(sigma, contacts[0].sigma)
    assert [one.load for one in felt] == sorted((one.load for one in felt), reverse=True)
    for one in felt:
        floor = max(one.contact.floor, 3 * sigma)
        height = x = y = load = 0.0
        for taxel in one.taxels.tolist():
            row, col = divmod(taxel, SIDE)
            value = one.contact.frame.padded[row + 1, col + 1]
            above = max(value - floor, 0.0)
            load, height = load + value, height + above
            x, y = x + above * (col - 7.5), y + above * (row - 7.5)
        assert one.load == pytest.approx(load)
        assert (one.sigma, one.peak) == (sigma, one.contact.peak)
        if height > 0:
            assert one.position == pytest.approx((x / height, y / height))


@given(st.sets(st.integers(0, SIDE * SIDE - 1), min_size=1, max_size=9), st.sets(st.integers(0, 255), min_size=1))
def test_a_gap_is_the_rows_or_columns_between(one: set[int], other: set[int]) -> None:
    contact = SimpleNamespace(shape=(SIDE, SIDE))
    felt: Any = [SimpleNamespace(taxels=np.array(sorted(t)), contact=contact) for t in (one, other)]
    apart = min(max(abs(a // SIDE - b // SIDE), abs(a % SIDE - b % SIDE)) for a in one for b in other)
    assert gap(*felt) == gap(*felt[::-1]) == apart - 1


def test_what_has_fallen_off_counts_by_its_load() -> None:
    main, part = felt_of(bump(-2, 1)), felt_of(bump(4, -3, 300.0))
    assert joined(main, []) is main
    both = joined(main, [part])
    assert both.load == pytest.approx(main.load + part.load)
    share = part.load / both.load
    for axis in (0, 1):
        assert both.position[axis] == pytest.approx((1 - share) * main.position[axis] + share * part.position[axis])
    assert sorted(both.taxels.tolist()) == sorted([*main.taxels.tolist(), *part.taxels.tolist()])
    assert both.peak == joined(part, [main]).peak == main.peak
    assert both.contact is main.contact


@given(st.integers(-3, 3), st.integers(-3, 3), st.integers(0, 2))
def test_a_touch_that_shares_a_contact_goes_along_with_it(right: int, down: int, shorter: int) -> None:
    """One side of what is shared may draw back: that is no motion of the whole."""
    alone = felt_of(bump(-1, 0, reach=1.0))
    touch = Touch(alone, 0.0, 0.0, number=1)
    before = felt_of(bump(0, 0, reach=4.0))
    touch.merge(before)
    touch.see(before, 0.1)
    assert touch.taxels.tolist() == alone.taxels.tolist()
    window = before.contact.window
    moved = (
        slice(window[0].start + down, window[0].stop + down),
        slice(window[1].start + right, window[1].stop + right - shorter),
    )
    contact = SimpleNamespace(shape=(SIDE, SIDE), window=moved)
    touch.see(Felt(contact, before.taxels, before.position, 1.0, 1.0, 1.0), 0.2)  # type: ignore[arg-type]
    sides = right, right - shorter
    along = 0 if sides[0] * sides[1] <= 0 else min(sides, key=abs)
    x, y = alone.position
    assert touch.expected == pytest.approx((x + along, y + down))
    assert touch.taxels.tolist() == (alone.taxels + down * SIDE + along).tolist()
    touch.part()
    assert not touch.is_merged


def test_what_leaves_the_pad_with_a_shared_contact_is_there_no_more() -> None:
    alone, shared = felt_of(bump(-5, 0, reach=1.0)), felt_of(bump(-3, 0))
    touch = Touch(alone, 0.0, 0.0, number=1)
    touch.merge(shared)
    rows, cols = shared.contact.window
    contact = SimpleNamespace(shape=(SIDE, SIDE), window=(rows, slice(cols.start - 3, cols.stop - 3)))
    touch.see(Felt(contact, shared.taxels, shared.position, 1.0, 1.0, 1.0), 0.2)  # type: ignore[arg-type]
    left = [taxel - 3 for taxel in alone.taxels.tolist() if taxel % SIDE >= 3]
    assert touch.taxels.tolist() == left
    assert len(left) < len(alone.taxels)


# The noise.


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.01, 1.0, 30.0]), st.sampled_from([0.002, 0.01, 0.05]))
@settings(max_examples=25)
def test_noise_is_measured_beside_what_moves(seed: int, sigma: float, step_s: float) -> None:
    rng, noise = np.random.default_rng(seed), Noise()
    known = []
    for k in range(120):
        frame = bump(-4 + k / 15, 0, 200 * sigma) + rng.normal(0, sigma, (SIDE, SIDE))
        if k % 9 == 8:
            frame[3, 3] += 1e4 * sigma
        noise.update(k * step_s, frame, feel(find_contacts(frame), noise.sigma))
        known.append(noise.is_known)
    assert known == [k >= 4 for k in range(120)]
    assert noise.sigma == pytest.approx(sigma, rel=0.3)


def test_noise_that_the_contacts_tell_counts_where_it_is_more() -> None:
    noise = Noise()
    frame = bump(0, 0) + np.random.default_rng(0).normal(0, 7, (SIDE, SIDE))
    contacts = find_contacts(frame)
    for k in range(9):
        noise.update(0.01 * k, frame, feel(contacts, 0.0))
    assert noise.sigma == contacts[0].sigma > 5


# When a touch is looked at.


@given(st.lists(st.sampled_from([0.004, 0.01, 0.05, 0.3]), min_size=1, max_size=80), st.integers(0, 9))
@settings(max_examples=30)
def test_looks_are_as_far_apart_as_is_said(steps: list[float], heaviest: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence, "recognize", lambda contact: contact)
        patch.setattr(evidence, "unsure_of_top", lambda surface: surface)
        patch.setattr(evidence, "EvidencePool", Pool)
        patch.setattr(evidence, "SteadyMean", Newest)
        looked, due, first, at = [], -math.inf, 0.0, 100.0
        its = Evidence()
        assert its.answer is None
        its.look(at - 1.0, SimpleNamespace(contact=SimpleNamespace(n_taxels=3), load=1.0))  # type: ignore[arg-type]
        assert its.looks == 0
        loads = {}
        for k, step in enumerate(steps):
            at += step
            load = 1.0 + 5.0 * (k == heaviest)
            its.look(at, SimpleNamespace(contact=SimpleNamespace(n_taxels=4, name=k), load=load))  # type: ignore[arg-type]
            if at >= due:
                first = first or at
                due = at + max(0.02, (at - first) / 16)
                looked.append(k)
                loads[k] = load
            assert its.looks == len(looked)
            assert its.answer.name == max(looked, key=lambda k: (loads[k], -k))  # type: ignore[union-attr]


class Pool:
    """Counts its looks; its answer is the one that it is asked about."""

    looks = 0

    def add(self, surface: object, *, frames: int) -> None:
        self.looks += 1

    def answer(self, best: object) -> object:
        return best


class Newest:
    """Knows no frame but the newest."""

    frames = 1

    def add(self, felt: object) -> None:
        pass

    def contact(self, felt: Felt) -> object:
        return felt.contact


# What lies still.


def _heap(x: float, load: float, seed: int, noise: float = 1.0) -> np.ndarray:
    rows, cols = np.mgrid[:16, :16]
    heap = 100 * load * np.maximum(1 - np.hypot(cols - 7.5 - x, rows - 7.5) / 6, 0)
    return heap + np.random.default_rng(seed).normal(0, noise, (16, 16))


def _felt(frame: np.ndarray, sigma: float = 1.0) -> Felt:
    return feel(find_contacts(frame, sigma=sigma, pitch=0.002), sigma)[0]


@given(st.integers(0, 2**16), st.integers(2, 30))
@settings(max_examples=30)
def test_what_lies_still_is_seen_with_less_noise(seed: int, count: int) -> None:
    steady = SteadyMean()
    felt = [_felt(_heap(0.0, 1.0, 1000 * seed + k)) for k in range(count)]
    for one in felt:
        steady.add(one)
    seen = steady.contact(felt[-1])
    assert steady.frames == min(count, 16)
    assert seen.pitch == felt[-1].contact.pitch
    # What stands above the noise that is left, down to a fiftieth of the peak.
    assert seen.floor == pytest.approx(max(4 * felt[-1].sigma / math.sqrt(steady.frames), 0.02 * seen.peak), rel=0.01)
    clean = _heap(0.0, 1.0, 0, noise=0.0)
    off = [np.abs(one.frame.padded[1:-1, 1:-1] - clean).mean() for one in (seen, felt[-1].contact)]
    assert off[0] < off[1] * (1.25 / math.sqrt(steady.frames) + 0.05)
    if count <= 16:
        mean = np.mean([one.contact.frame.padded[1:-1, 1:-1] for one in felt], axis=0)
        np.testing.assert_allclose(seen.frame.padded[1:-1, 1:-1], mean, atol=1e-9)


@pytest.mark.parametrize(("x", "load"), [(0.8, 1.0), (-1.5, 1.0), (0.0, 1.3), (0.0, 0.8)])
def test_what_moves_or_is_pressed_otherwise_is_looked_at_anew(x: float, load: float) -> None:
    steady = SteadyMean()
    for k in range(5):
        steady.add(_felt(_heap(0.0, 1.0, k)))
    after = _felt(_heap(x, load, 9))
    steady.add(after)
    assert steady.frames == 1
    assert steady.contact(after) is after.contact
    steady.add(_felt(_heap(x, load, 10)))
    assert steady.frames == 2


def test_gaps_and_losses_stay() -> None:
    frame = _heap(0.0, 1.0, 0)
    frame[:, 0] = np.nan
    steady = SteadyMean()
    for _ in range(3):
        felt = feel(with_losses(find_contacts(frame, sigma=1.0), beneath=2.5), 1.0)[0]
        steady.add(felt)
    seen = steady.contact(felt)
    assert not seen.frame.field[:, 0].any()
    assert seen.frame.field[:, 1:].all()
    assert seen.frame.losses.beneath == 2.5
    assert seen.n_taxels == pytest.approx(felt.contact.n_taxels, abs=12)


# What changed, and what that is.


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(0.8, 1.25), st.floats(1.0, 1.6))
@settings(max_examples=40)
def test_a_heap_that_moves_and_grows_is_told_by_how_much(x: float, y: float, load: float, stretch: float) -> None:
    rest = Rest(felt_of(bump(0, 0, stretch=stretch)))
    change = rest.change(load * bump(x, y, stretch=stretch), 1.0)
    assert change.load == pytest.approx(load, abs=0.05)
    assert change.shift == pytest.approx((load * x, load * y), abs=0.06)
    # A heap of this form scatters about its middle as its formula says.
    assert change.breadth((1.0, 0.0)) == pytest.approx(stretch * math.sqrt(2), rel=0.1)
    assert change.breadth((0.0, 3.0)) == pytest.approx(math.sqrt(2), rel=0.1)
    assert change.breadth((1.0, 1.0)) == pytest.approx(math.sqrt(1 + stretch**2), rel=0.1)


def test_noise_scatters_what_is_told_as_far_as_is_said() -> None:
    rng, sigma = np.random.default_rng(0), 20.0
    rest = Rest(felt_of(bump(0, 0), sigma))
    found = [rest.change(bump(0, 0) + rng.normal(0, sigma, (SIDE, SIDE)), sigma) for _ in range(300)]
    for name in ("shift", "lean"):
        scatter = max(np.std([getattr(change, name) for change in found], axis=0).tolist())
        said = getattr(found[0], f"{name}_sigma") / math.sqrt(2)
        assert scatter == pytest.approx(said, rel=0.3)


@given(st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(0.05, 1)), min_size=1, max_size=6))
def test_a_rest_is_the_mean_of_what_was_added_by_its_share(course: list[tuple[float, float]]) -> None:
    rest = Rest(felt_of(bump(0, 0)))
    mean, position = bump(0, 0), np.array(felt_of(bump(0, 0)).position)
    for x, share in course:
        rest.add(felt_of(bump(x, 0)), bump(x, 0), share)
        mean = mean + share * (bump(x, 0) - mean)
        position = position + share * (np.array(felt_of(bump(x, 0)).position) - position)
    assert rest.frames == 1 + len(course)
    assert rest.position == pytest.approx(tuple(position), abs=1e-9)
    nothing = rest.change(mean, 1.0)
    assert nothing.load == pytest.approx(1.0, abs=1e-6)
    assert (*nothing.shift, *nothing.lean) == pytest.approx((0, 0, 0, 0), abs=1e-6)


# Whether a touch rests or moves.


def told_of(
    ways: list[float], loads: list[float] | None = None, *, step_s: float = STEP_S, sigma: float = 1.0
) -> tuple[list[tuple[int, Told]], list[str]]:
    """Return what is told of a heap that goes along x, with the number of its frame; and the states."""
    motion, found, states = Motion(), [], []
    for k, x in enumerate(ways):
        frame = bump(x, 0, 1000.0 if loads is None else loads[k])
        told = motion.update(k * step_s, felt_of(frame, sigma), frame)
        states.append(motion.state)
        if told is not None:
            found.append((k, told))
    return found, states


@pytest.mark.parametrize(("way", "moves"), [(0.06, False), (0.11, False), (0.19, True), (0.3, True), (-0.3, True)])
def test_what_goes_too_little_a_way_has_not_moved(way: float, moves: bool) -> None:
    found, states = told_of([0.0] * 40 + [way] * 60)
    assert bool(found) is moves
    if moves:
        (first, told), (_, last) = found
        # Two frames must say it, and the motion is told of the first of them.
        assert first == 41
        assert (told.kind, told.is_new, told.resting) == ("moved", True, False)
        assert told.time_s == pytest.approx(40 * STEP_S)
        assert told.way == pytest.approx((way, 0.0), abs=0.03)
        assert (last.is_new, last.resting) == (False, True)
        assert states[-1] == "hold"


def test_one_frame_that_says_so_is_no_motion() -> None:
    assert told_of([0.0] * 40 + [0.5] + [0.0] * 40)[0] == []


def test_a_motion_is_told_again_taxel_by_taxel_until_it_rests() -> None:
    found, states = told_of([0.0] * 40 + [k * 0.02 for k in range(200)] + [3.98] * 60)
    assert [told.is_new for _, told in found] == [True] + [False] * (len(found) - 1)
    assert [told.resting for _, told in found] == [False] * (len(found) - 1) + [True]
    far = [told.way[0] for _, told in found]
    assert np.diff(far[:-1]) == pytest.approx(1.0, abs=0.1)
    assert far[-1] == pytest.approx(3.98, abs=0.05)
    assert {"motion"} == set(states[60:230])
    # It rests once it has stood for a fifth of a second, or nearly.
    assert 0.1 < (found[-1][0] - 240) * STEP_S < 0.25


def test_a_contact_rests_once_its_load_is_steady() -> None:
    rises = np.linspace(100, 1000, 60).tolist()
    found, states = told_of([0.0] * 120, rises + [1000.0] * 60)
    assert found == []
    assert set(states[:60]) == {"onset"}
    first = states.index("hold")
    assert 0 < (first - 59) * STEP_S <= 0.06
    assert set(states[first:]) == {"hold"}
    # It is another rest where the load is another.
    _, states = told_of([0.0] * 160, [1000.0] * 60 + np.linspace(1000, 2000, 40).tolist() + [2000.0] * 60)
    assert "onset" in states[60:100]
    assert states[-1] == "hold"


def test_a_drift_that_takes_minutes_is_no_motion() -> None:
    course = np.linspace(0, 0.5, 1500).tolist()
    assert told_of([0.0] * 40 + course, step_s=0.02)[0] == []


def test_noise_alone_is_told_to_move_nowhere() -> None:
    rng, motion = np.random.default_rng(3), Motion()
    for k in range(400):
        frame = bump(0, 0, 400.0) + rng.normal(0, 30, (SIDE, SIDE))
        contacts = feel(find_contacts(frame, sigma=30.0), 30.0)
        assert motion.update(k * STEP_S, contacts[0], frame) is None


def test_what_leaves_while_it_moves_is_told_as_far_as_it_went() -> None:
    ways = [0.0] * 40 + [k * 0.03 for k in range(20)] + [0.57] * 20
    loads = [1000.0] * 60 + np.linspace(1000, 100, 20).tolist()
    found, states = told_of(ways, loads)
    assert found[0][1].is_new
    assert found[-1][1].resting
    assert 0.3 < found[-1][1].way[0] < 0.65
    assert states[-1] != "motion"


def lean(by: float) -> np.ndarray:
    """Return a flat face that leans to +x, and one taxel of slope around it."""
    rows, cols = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    inside = np.clip(5.5 - np.hypot(rows, cols), 0, 1)
    return np.asarray(1000 * inside * (1 + by * cols / 5))


@pytest.mark.parametrize(("by", "tips"), [(0.05, False), (0.5, True)])
def test_what_leans_far_enough_has_tipped(by: float, tips: bool) -> None:
    motion, found = Motion(), []
    for k, at in enumerate([0.0] * 40 + np.linspace(0, by, 20).tolist() + [by] * 80):
        told = motion.update(k * STEP_S, felt_of(lean(at)), lean(at))
        found += [] if told is None else [told]
    assert {told.kind for told in found} == ({"tipped"} if tips else set())
    if tips:
        assert found[-1].resting
        height = np.maximum(lean(by), 0)
        cols = np.arange(SIDE) - 7.5
        assert found[-1].way == pytest.approx((float((height * cols).sum() / height.sum()), 0.0), abs=0.15)
