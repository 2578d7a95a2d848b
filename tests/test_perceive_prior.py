"""What is known of a name before anything is touched: it is evidence that is no touch."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.toy_library import OBJECTS, library, touches

from varishold.errors import FormatError, InputError
from varishold.perceive import NameEvidence, Perceiver, read_prior

NAMES = tuple(OBJECTS)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_a_prior_says_what_the_same_answer_says_later_and_is_no_touch(seed: int) -> None:
    rng = np.random.default_rng(seed)
    said = dict(zip(NAMES, rng.dirichlet(np.ones(len(NAMES))).tolist(), strict=True))
    felt = touches(1.0, rng)[0]
    before, later = Perceiver(library(), prior=said), Perceiver(library())
    with pytest.raises(InputError, match="nothing was touched yet"):
        before.answer()
    assert not before.stopped
    update = before.feel(felt)
    later.feel(felt)
    last = later.feel(NameEvidence("prior", said))
    assert update.probability == pytest.approx(last.probability, rel=1e-9)
    assert len(before.answer().trace) == 1
    assert update.reasons[0].startswith("prior: ")
    before.forget()
    assert before.feel(felt).probability == pytest.approx(update.probability)


def test_a_prior_resolves_a_doubt_and_decides_what_to_touch() -> None:
    sure = Perceiver(library(), prior={NAMES[0]: 0.98, NAMES[1]: 0.02})
    probability = sure.belief.probability
    assert max(probability, key=probability.__getitem__) == NAMES[0]
    assert Perceiver(library()).belief.probability[NAMES[0]] < probability[NAMES[0]]
    assert sure.next_touch() is not None


def test_names_that_the_library_does_not_know() -> None:
    with pytest.raises(InputError, match="none of which is an object of the library"):
        Perceiver(library(), prior={"mug": 1.0})
    partly = Perceiver(library(), prior=NameEvidence("camera", {"mug": 0.9, NAMES[0]: 0.1}))
    partly.feel(touches(1.0, np.random.default_rng(0))[0])
    assert any("mug, which the library does not know" in remark for remark in partly.answer().remarks)


def test_a_prior_that_names_no_object_of_the_library_is_told_with_its_file(tmp_path: Path) -> None:
    path = tmp_path / "camera.json"
    path.write_text('{"probability": {"mug": 1}}')
    with pytest.raises(FormatError, match=r"camera\.json: 'camera' knows mug, none of which is an object"):
        read_prior(path, library().objects)
    assert read_prior(path, ("mug", "cup")).probability == {"mug": 1.0}


def test_of_which_objects_a_prior_says_nothing_is_told_once() -> None:
    told = "camera: says nothing of {}, which it does not name; give 0 to what it has ruled out"
    silent = Perceiver(library(), prior=NameEvidence("camera", {NAMES[0]: 1.0}))
    # Sure of one name alone, it says no more than a camera that knows nothing else.
    assert len(set(silent.belief.probability.values())) == 1
    silent.feel(touches(1.0, np.random.default_rng(0))[0])
    assert silent.answer().remarks.count(told.format(", ".join(NAMES[1:]))) == 1
    ruled_out = dict.fromkeys(NAMES, 0.0) | {NAMES[0]: 1.0}
    sure = Perceiver(library(), prior=NameEvidence("camera", ruled_out))
    assert sure.belief.probability[NAMES[0]] > 0.9
    assert not any("says nothing" in remark for remark in sure.belief.remarks)
    strange = Perceiver(library(), prior=NameEvidence("camera", {NAMES[0]: 1.0}, p_value=0.01))
    assert not any("says nothing" in remark for remark in strange.belief.remarks)


@pytest.mark.parametrize("source", ["a\x1b[2J", "two\nlines", 201 * "x"])
def test_who_says_a_name_is_printed_on_one_line(source: str) -> None:
    with pytest.raises(InputError, match="must be called by at most 200 printable characters") as told:
        NameEvidence(source, {"cone": 1.0})
    assert str(told.value).isprintable()
    assert len(str(told.value)) < 320


def test_what_a_camera_wrote_is_read(tmp_path: Path) -> None:
    path = tmp_path / "camera.json"
    path.write_text(json.dumps({"source": "camera", "probability": {"cone": 0.7, "ball": 0.3}, "weight": 0.5}))
    assert read_prior(path) == NameEvidence("camera", {"cone": 0.7, "ball": 0.3}, weight=0.5)


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("[1, 2]", 'must be {"source": WHO'),
        ('{"source": "camera"}', 'must be {"source": WHO'),
        ('{"source": "camera", "probability": {}}', "probability of 'camera' must be numbers by name, got none"),
        ('{"probability": {"cone": 0.7, "box": 0.7}}', "probability of 'camera' must be from 0 to 1 and sum to 1"),
        ('{"source": "camera", "probability": {"cone": 0.5}}', "sum to 1"),
        ('{"source": "camera", "probability": {"cone": "high"}}', "numbers by name"),
        ('{"source": "camera", "probability": {"cone": 1}, "turn": 1}', "has no key 'turn'"),
        ('{"source": "camera", "probability": {"cone": 1}, "pose": 1}', "pose must be {size_m: METRES"),
        ('{"source": "camera", "probability": {"cone": 1}, "pose": {"turn_rad": 1}}', "keeps no turn"),
        (
            '{"source": "camera", "probability": {"cone": 1}, "pose": {"size_m": 80, "size_sigma_m": 5}}',
            "is it in millimetres?",
        ),
        (
            '{"source": "camera", "probability": {"cone": 1}, "pose": {"size_m": 0.08, "size_sigma_m": 0}}',
            "size_sigma_m of a pose must be positive",
        ),
        ('{"source": "camera", "probability": {"cone": 1}, "weight": 2}', "weight of 'camera'"),
        ('{"source": "camera", "probability": {"cone": true}}', "probability of 'camera' must be numbers by name"),
        ('{"source": "camera", "probability": {"cone": 1}, "weight": true}', "weight of 'camera'"),
        ('{"source": 3, "probability": {"cone": 1}}', "must have a name"),
        ("{", "not complete JSON"),
    ],
)
def test_what_is_no_prior_is_told_in_one_line(tmp_path: Path, written: str, told: str) -> None:
    path = tmp_path / "camera.json"
    path.write_text(written)
    with pytest.raises(FormatError) as error:
        read_prior(path)
    assert str(error.value).startswith(str(path))
    assert told in str(error.value)
    assert "\n" not in str(error.value)
