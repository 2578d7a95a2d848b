"""Readings that fall where something presses: no name is sure, and none of a sensor that only seems to is lost."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from tests.live_scripted import Scripted, wait_until

from varishold.errors import InputError
from varishold.frame.polarity import find_fall
from varishold.live import PadLayout, Sample
from varishold.live.session import Session
from varishold.live.watcher import Seen, Watcher

N, RATE_HZ = 16, 50
Y, X = np.mgrid[:N, :N]
EVERYWHERE = np.ones((N, N), np.bool_)
HEIGHT = 150.0


def off(place: np.ndarray) -> np.ndarray:
    return np.hypot(X - place[0], Y - place[1])


def ball(place: np.ndarray) -> np.ndarray:
    return HEIGHT * np.sqrt(np.maximum(1.0 - (off(place) / 4.0) ** 2, 0.0))


def plate(place: np.ndarray) -> np.ndarray:
    return HEIGHT * ((np.abs(X - place[0]) < 3.6) & (np.abs(Y - place[1]) < 3.6))


def pulled(place: np.ndarray) -> np.ndarray:
    """A skin that is pulled down where it is pressed lifts the taxels around it."""
    return ball(place) - 0.25 * HEIGHT * np.exp(-(((off(place) - 5.5) / 1.5) ** 2)) * (off(place) > 4.0)


def sent(
    solid=ball, *, sign: float = 1.0, start_s: float = 1.2, press_s: float = 1.0, seconds: float = 8.0, seed: int = 0
) -> Iterator[tuple[float, np.ndarray, bool]]:
    """Presses at places of their own, as far apart as they are long: time, frame, and whether something presses."""
    rng = np.random.default_rng(seed)
    rest = 250.0 + rng.normal(0.0, 3.0, (N, N))
    place, was = np.array([7.5, 7.5]), -1
    for k in range(int(seconds * RATE_HZ)):
        press, since_s = divmod(k / RATE_HZ - start_s, 2.0 * press_s)
        if press >= 0 and press != was:
            place, was = rng.uniform(4.0, 11.0, 2), int(press)
        share = min(max(min(since_s, press_s - since_s) / 0.1, 0.0), 1.0) if press >= 0 else 0.0
        yield k / RATE_HZ, rest + sign * share * solid(place) + rng.normal(0.0, 1.0, (N, N)), share > 0.0


def watched(frames, watcher: Watcher | None = None) -> list[tuple[Seen, bool]]:
    with watcher or Watcher() as watching:
        return [(watching.see(Sample(at, at, None, {"pad": frame})), pressed) for at, frame, pressed in frames]


def answers(seen: list[tuple[Seen, bool]]) -> list[tuple[str, float]]:
    """Names and how sure they are, while something presses and while not."""
    found = [track.answer for one, _ in seen for track in one.pads["pad"].tracks]
    return [(answer.name, answer.probability) for answer in found if answer is not None]


def surest_form(seen: list[tuple[Seen, bool]]) -> float:
    return max((p for name, p in answers(seen) if name != "unknown"), default=0.0)


def remarked(seen: list[tuple[Seen, bool]]) -> list[bool]:
    return [any("fall where something presses" in words for words in one.pads["pad"].remarks) for one, _ in seen]


@pytest.mark.parametrize("solid", [ball, plate])
@pytest.mark.parametrize(("start_s", "press_s"), [(0.3, 0.3), (0.6, 1.0), (0.9, 3.0), (1.5, 0.3), (3.0, 1.0)])
def test_no_form_is_sure_where_readings_fall(solid, start_s: float, press_s: float) -> None:
    seen = watched(sent(solid, sign=-1.0, start_s=start_s, press_s=press_s))
    told = remarked(seen)
    assert told[-1]
    first = told.index(True)
    assert all(told[first:])
    assert sum(one.pads["pad"].is_news for one, _ in seen) == 1
    assert surest_form(seen) <= 0.55 + 1e-9
    assert surest_form(seen[first:]) == 0.0
    assert answers(seen[first:])


def test_a_stream_that_begins_while_something_presses_is_unsure_before_half_a_second() -> None:
    seen = watched(sent(sign=-1.0, start_s=0.0, press_s=0.5))
    assert surest_form(seen[RATE_HZ // 2 :]) <= 0.55 + 1e-9
    assert remarked(seen)[-1]


@pytest.mark.parametrize("solid", [ball, plate, pulled])
@pytest.mark.parametrize("seed", range(3))
def test_readings_that_rise_are_named_whatever_lies_beside_a_press(solid, seed: int) -> None:
    seen = watched(sent(solid, seed=seed))
    assert not any(remarked(seen))
    assert surest_form([(one, pressed) for one, pressed in seen if pressed]) > 0.9


def test_what_sinks_after_a_press_and_comes_back_is_no_press() -> None:
    def sinking() -> Iterator[tuple[float, np.ndarray, bool]]:
        left, last = np.zeros((N, N)), np.zeros((N, N))
        for at, frame, pressed in sent():
            left = np.maximum(left * np.exp(-1.0 / RATE_HZ / 0.6), 0.4 * np.maximum(last - 260.0, 0.0) * pressed)
            last = frame
            yield at, frame - left * (not pressed), pressed

    seen = watched(sinking())
    assert not any(remarked(seen))
    assert surest_form([(one, pressed) for one, pressed in seen if pressed]) > 0.9


def test_a_rest_that_sinks_in_part_of_the_pad_is_no_press() -> None:
    dent = np.exp(-(((X - 12) ** 2 + (Y - 4) ** 2) / 12.0))
    seen = watched((at, frame - 10.0 * at * dent, pressed) for at, frame, pressed in sent())
    assert not any(remarked(seen))
    assert surest_form(seen) > 0.9


@pytest.mark.parametrize("fails_s", [0.5, 5.0])
def test_a_corner_that_fails_takes_no_name_for_longer_than_until_the_next_press(fails_s: float) -> None:
    corner = (X < 4) & (Y < 5)
    frames = [(at, np.where(corner & (at > fails_s), 0.0, f), pressed) for at, f, pressed in sent(seconds=12.0)]
    seen = watched(frames)
    assert not any(remarked(seen)[-4 * RATE_HZ :])
    assert surest_form(seen[-4 * RATE_HZ :]) > 0.9


def test_frames_of_a_skin_that_is_pulled_beside_a_press_do_not_fall() -> None:
    """A narrow press with a wide ring: in all more falls than rises."""
    rng = np.random.default_rng(0)
    frames = []
    for place in rng.uniform(4.0, 11.0, (8, 2)):
        ring = 0.3 * HEIGHT * np.exp(-(((off(place) - 4.5) / 2.0) ** 2)) * (off(place) > 2.2)
        frames += [np.zeros((N, N))] * 3 + [HEIGHT * np.maximum(1.0 - (off(place) / 2.2) ** 2, 0.0) - ring] * 3
    assert np.sum(frames) < 0.0
    noisy = np.array(frames) + rng.normal(0.0, 1.0, (len(frames), N, N))
    assert find_fall(noisy, EVERYWHERE) is None
    assert find_fall(np.array(frames), EVERYWHERE) is None


class Taught:
    """A model that calls everything a cup."""

    classes_ = np.array(["cup"])

    def explain(self, presses):
        return ["cup" for _ in presses]


@pytest.mark.parametrize(("sign", "named"), [(1.0, True), (-1.0, False)])
def test_a_model_names_no_press_of_readings_that_fall(sign: float, named: bool) -> None:
    watcher = Watcher(model=Taught())  # type: ignore[arg-type]
    for at, frame, _ in sent(sign=sign, seconds=12.0):
        seen = watcher.see(Sample(at, at, None, {"pad": frame}))
    pad = watcher.pads["pad"]
    assert (pad.wrong_way is None) == named
    told = watcher.finish()
    assert told is not None
    assert told.named
    for press in told.named[-1:]:
        assert (press.recognition is not None) == named
        assert ("fall where something presses" in press.words) != named
    watcher.close()
    assert seen.number > 0


def test_a_sensor_that_is_said_to_fall_and_rises_is_named_no_more_surely() -> None:
    from varishold.sensor import Sensor

    seen = watched(sent(), Watcher(sensor=Sensor(polarity="down", rest=250.0, span=250.0)))
    assert surest_form(seen) <= 0.55 + 1e-9
    assert any("is the polarity right?" in words for words in seen[-1][0].pads["pad"].remarks)


def test_the_zero_tells_its_newest_frame_once_there_is_one() -> None:
    from varishold.frame.zero import FollowingZero

    zero = FollowingZero((3, 3))
    with pytest.raises(InputError, match="no frame was taken yet"):
        _ = zero.reading
    zero.update(0.0, np.full((3, 3), 7.0))
    assert (zero.reading == 7.0).all()


def test_no_press_of_readings_that_fall_is_kept_to_learn_from() -> None:
    source = Scripted()
    source.pads = {"pad": PadLayout((N, N))}
    with Session(source) as session:
        session.set_label("cup")
        for at, frame, _ in sent(sign=-1.0, seconds=10.0):
            source.script.put(Sample(at, 1e9 + at, None, {"pad": frame}))
        told = "the press is not kept: readings fall where something presses"
        wait_until(lambda: any(told in event["words"] for event in session.events.since(0)))
