"""The search, step by step, on a bench whose world is the test's."""

from __future__ import annotations

import pytest
from tests.scripted_bench import ScriptedBench, angles_at

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.hand import HandDesign
from varishold.hand.actions import (
    search,
)

DESIGN = HandDesign()
ALL = tuple(DESIGN.digits)
FINGERS = ("index", "middle", "ring", "little")


class Before:
    """Something upright before the hand: its middle aside, its breadth, and where the palm meets it."""

    def __init__(self, aside_m: float, breadth_m: float = 0.06, ahead_m: float = 0.05, low: bool = False) -> None:
        self.aside_m, self.breadth_m, self.ahead_m, self.low = aside_m, breadth_m, ahead_m, low
        self.shifts: list[float] = []

    def __call__(self, b: ScriptedBench) -> tuple[str, ...]:
        middle = self.aside_m - b.target["shift"]
        on: tuple[str, ...] = ()
        if b.target["reach"] >= self.ahead_m:
            if abs(middle) < 0.035:
                on += ("palm_centre",)
            else:
                # A digit's end meets it before the palm does.
                on += ("ring_distal",) if middle > 0 else ("thumb_distal",)
        finger = "middle" if self.low else "index"
        if finger in b.closing and "thumb" in b.closing:
            b.angles = angles_at(middle + self.breadth_m / 2, middle - self.breadth_m / 2)
            if self.low:
                b.angles[3:6] = b.angles[:3]
                b.angles[:3] = DESIGN.open_rad
            on += (f"{finger}_distal", "thumb_distal")
        if b.target["shift"] not in self.shifts:
            self.shifts.append(b.target["shift"])
        return on


def test_what_stands_right_before_the_hand_is_found_at_once() -> None:
    bench = ScriptedBench(world=Before(0.004))
    found = search(bench)
    assert (found.found, found.touches, found.shift_m) == (True, 1, 0.0)
    feel = [entry for entry in bench.log if entry[0] == "digits"]
    assert feel == [
        ("digits", {"index": 0.3, "thumb": 0.3}, ("middle", "ring", "little"), {}),
        ("digits", {}, ALL, {}),
    ]
    # As soon as both touch it is felt: one wait of .06 s.
    assert [seconds for seconds, told in bench.moves() if not told] == [0.06, 0.15]


def test_what_is_low_is_felt_for_with_the_other_fingers() -> None:
    bench = ScriptedBench(world=Before(0.002, low=True))
    assert search(bench).found
    feel = [entry[1:3] for entry in bench.log if entry[0] == "digits"]
    assert feel == [
        ({"index": 0.3, "thumb": 0.3}, ("middle", "ring", "little")),
        ({"middle": 0.3, "ring": 0.3, "little": 0.3, "thumb": 0.3}, ("index",)),
        ({}, ALL),
    ]
    assert [seconds for seconds, told in bench.moves() if not told] == [0.06] * 8 + [0.06, 0.15]


@pytest.mark.parametrize("aside", [0.02, -0.02])
def test_four_fifths_of_an_offset_are_made_up_for_at_a_time(aside: float) -> None:
    world = Before(aside)
    bench = ScriptedBench(world=world)
    found = search(bench)
    assert (found.found, found.touches) == (True, 2)
    assert found.shift_m == pytest.approx(0.8 * aside)
    # It steps back by 12 mm before it goes aside.
    k = next(k for k, (_, told) in enumerate(bench.moves()) if told.get("shift"))
    back, aside_way = bench.moves()[k - 1 : k + 1]
    assert (back[0], aside_way[0]) == (0.06, 0.1)
    before = next(told for _, told in reversed(bench.moves()[: k - 1]) if "reach" in told)
    assert back[1]["reach"] == pytest.approx(before["reach"] - 0.012)
    # Within 5 mm it stands well enough; after three touches wherever it is.
    assert search(ScriptedBench(world=Before(0.0049))).touches == 1
    assert search(ScriptedBench(world=Before(0.0055))).touches == 2

    class Fleeing(Before):
        def __call__(self, b: ScriptedBench) -> tuple[str, ...]:
            self.aside_m = b.target["shift"] + 0.02
            return super().__call__(b)

    fleeing = search(ScriptedBench(world=Fleeing(0.02)))
    assert (fleeing.found, fleeing.touches) == (True, 3)
    assert fleeing.shift_m == pytest.approx(2 * 0.8 * 0.02)


def test_after_a_digit_met_it_the_hand_steps_aside_and_halves_its_steps_when_it_went_too_far() -> None:
    world = Before(0.045)
    found = search(ScriptedBench(world=world))
    assert found.found
    # A ring finger's touch: it lies on the fingers' side.
    assert world.shifts[:2] == pytest.approx([0.0, 0.012])

    class Narrow(Before):
        """A post that digits alone meet: now on one side, now on the other."""

        def __call__(self, b: ScriptedBench) -> tuple[str, ...]:
            super().__call__(b)
            if b.target["reach"] < self.ahead_m:
                return ()
            return ("ring_distal",) if b.target["shift"] < self.aside_m else ("thumb_distal",)

    narrow = Narrow(0.031)
    bench = ScriptedBench(world=narrow)
    lost = search(bench)
    assert not lost.found
    assert lost.touches == 0
    told = [0.0, 0.012, 0.024, 0.036, 0.030, 0.033, 0.0315, 0.03075, 0.031125]
    assert narrow.shifts[:9] == pytest.approx(told, abs=1e-6)
    # Twelve moves, and no more.
    assert sum(seconds == 0.1 for seconds, _ in bench.moves()) == 12


def test_nothing_felt_is_nothing_found_unless_it_was_felt_before() -> None:
    bench = ScriptedBench()
    found = search(bench)
    assert (found.found, found.touches) == (False, 1)
    assert bench.moves()[-1][0] == 0.15
    # The palm went as far as it was let.
    assert bench.target["reach"] == pytest.approx(0.18, abs=0.0013)
    near_by = ScriptedBench()
    search(near_by, most_m=0.05)
    assert near_by.target["reach"] == pytest.approx(0.05, abs=0.0013)

    class Gone(Before):
        def __call__(self, b: ScriptedBench) -> tuple[str, ...]:
            return super().__call__(b) if b.target["shift"] == 0 else ()

    gone = search(ScriptedBench(world=Gone(0.02)))
    assert (gone.found, gone.touches) == (True, 2)


def test_a_palm_that_touches_is_squared_up_before_the_feel() -> None:
    world = Before(0.0)

    def turned(b: ScriptedBench) -> tuple[str, ...]:
        on = world(b)
        return tuple("palm_finger_upper" if name == "palm_centre" else name for name in on)

    bench = ScriptedBench(world=turned)
    search(bench)
    assert bench.target["turn"] == pytest.approx(0.36)
