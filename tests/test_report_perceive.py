"""The page of `varishold perceive`: sound, self-contained, deterministic, and complete."""

from __future__ import annotations

import base64
import html
import html.parser
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.errors import InputError
from varishold.exploration import TOUCHES, Exploration, grip_contacts, perceive
from varishold.hand import OBJECTS, HandDesign, HandSetting, PadSetting
from varishold.perceive import NONE_OF_THESE, GripContacts, Perceiver, library_file
from varishold.report import render_perceive_report, write_perceive_report
from varishold.report.belief_chart import belief_chart, size_strip
from varishold.report.exploration_words import (
    answer_in_words,
    next_in_words,
    truth_in_words,
    was_right,
)
from varishold.report.grip_drawing import SECTION_OF, grip_drawing
from varishold.report.photo import photo_data_uri

needs_library = pytest.mark.skipif(
    not library_file._SHIPPED.is_file(), reason="no library of objects is shipped; python -m training.objects makes it"
)
SETTING = HandSetting(pads=PadSetting())


@pytest.fixture(scope="module")
def sequence() -> Exploration:
    """A grasp, a grip from the side and a fingertip, whatever they tell."""
    order = ("grasp", "regrasp-turned-45", "fingertip-middle")
    sure_never = Perceiver(error=1e-12, least_touches=3)
    return perceive("hexagonal-prism", 0.07, seed=1, perceiver=sure_never, setting=SETTING, order=order)


class _Sound(html.parser.HTMLParser):
    """Counts tags and says whether each is closed."""

    VOID = frozenset({"meta", "link", "img", "br"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        self.ids += [value or "" for key, value in attrs if key == "id"]
        self.addresses += [value or "" for key, value in attrs if key in ("src", "href")]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.addresses += [value or "" for key, value in attrs if key in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def text_of(page: str) -> str:
    return html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", page.split("<main>")[1])))


@needs_library
def test_a_page_is_sound_and_needs_nothing_from_outside(sequence: Exploration) -> None:
    page = render_perceive_report(sequence, setting=SETTING, error=0.01)
    sound = _Sound()
    sound.feed(page)
    assert sound.open == []
    assert len(set(sound.ids)) == len(sound.ids)
    assert all(address.startswith(("data:", "#")) for address in sound.addresses)
    assert "<script" not in page
    assert page == render_perceive_report(sequence, setting=SETTING, error=0.01)


@needs_library
def test_a_page_tells_each_touch_with_its_reasons(sequence: Exploration) -> None:
    page = render_perceive_report(sequence, setting=SETTING)
    text = text_of(page)
    assert page.count('<article class="card touch"') == 3
    assert page.count('class="screen grip"') == 2
    assert page.count('class="screen hand"') == 2
    assert page.count('class="screen pads tip"') == 1
    assert page.count('class="growth belief"') == 2
    for object_name in OBJECTS:
        assert object_name.replace("-", " ") in text.lower()
    for touch in sequence.touches:
        assert touch.felt.touch.done[1:] in text
        assert touch.felt.touch.felt_in_words(touch.felt, touch.surfaces)[1:] in text
    assert "It goes on:" in text
    assert "It would go on, but no touch is left:" in text
    assert truth_in_words(sequence) in text
    assert "the triangle is the true size" in text


@needs_library
def test_every_pad_stands_in_the_drawing(sequence: Exploration) -> None:
    page = render_perceive_report(sequence, setting=SETTING)
    first = page.split('<article class="card touch"')[1]
    hand = first[first.index('class="screen hand"') : first.index("</div>", first.index('class="screen hand"'))]
    pressed = sum(bool(frame.any()) for frame in sequence.touches[0].felt.step.pads.frames.values())
    assert hand.count('class="idle"') == len(HandDesign().parts) - pressed
    assert hand.count("<image ") == pressed
    assert hand.count('class="switch') == 22
    assert hand.count('class="switch on"') == int(sequence.touches[0].felt.step.sensed.switches.sum())


@needs_library
def test_pictures_are_shown_one_a_touch_or_not_at_all(sequence: Exploration) -> None:
    picture = np.zeros((4, 5, 3), np.uint8)
    assert render_perceive_report(sequence, pictures=[picture] * 3).count('class="photo still"') == 3
    assert 'class="photo still"' not in render_perceive_report(sequence, pictures=[picture])
    assert "Pictures are left out. No GL." in text_of(render_perceive_report(sequence, no_pictures="no GL"))


@needs_library
def test_what_a_user_wrote_is_escaped(sequence: Exploration) -> None:
    hostile = "<script>alert(1)</script>"
    perception = replace(sequence.perception, remarks=(hostile,))
    page = render_perceive_report(replace(sequence, name=hostile, perception=perception))
    assert hostile not in page


@needs_library
def test_answers_are_judged(sequence: Exploration) -> None:
    told = replace(sequence.perception, object="hexagonal-prism", size_m=0.0714)
    assert was_right(replace(sequence, perception=told))
    assert "Right: it is a hexagonal prism of 70 mm; the size is 2.0 % off." == truth_in_words(
        replace(sequence, perception=told)
    )
    assert not was_right(replace(sequence, name="box", perception=told))
    lying = replace(sequence, name="box", perception=told, also_right=("hexagonal-prism",))
    assert was_right(lying)
    assert "Right: it is a box of 70 mm, which is a hexagonal prism as well; the size is" in truth_in_words(lying)
    none = replace(told, object=NONE_OF_THESE, size_m=None)
    stranger = replace(sequence, name="torus", perception=none)
    assert was_right(stranger)
    assert "it is a torus of 70 mm, which the library does not know" in truth_in_words(stranger)
    assert "none of the 10 objects it knows" in answer_in_words(stranger)
    assert was_right(replace(sequence, perception=none)) is False


def test_nothing_gripped_is_an_answer() -> None:
    nothing = Exploration("cone", 0.06, 0, (), 9, None)
    assert was_right(nothing) is None
    page = text_of(render_perceive_report(nothing))
    assert "Nothing was gripped: the hand missed or dropped the object 9 times and gave up." in page
    assert "It was a cone of 60 mm." in page


@needs_library
def test_an_answer_that_is_not_sure_says_why_it_stopped(sequence: Exploration) -> None:
    assert "stopped without being sure. No other touch was left." in answer_in_words(sequence)
    *first, last = sequence.touches
    lost = replace(sequence, touches=(*first, replace(last, then=("regrasp-lower", 0.1))), drops=9)
    assert "The hand lost the object 9 times and gave up." in answer_in_words(lost)
    enough = replace(sequence.perception.trace[-1], verdict="enough")
    perception = replace(sequence.perception, trace=(*sequence.perception.trace[:-1], enough))
    assert "No more touches were allowed." in answer_in_words(replace(sequence, perception=perception))


@needs_library
def test_the_next_touch_is_told_with_what_it_is_chosen_for(sequence: Exploration) -> None:
    first = replace(sequence.touches[0], then=("regrasp-lower", 0.5))
    assert next_in_words(first) == "regrasp-lower, expected to tell 0.50 nats (0.72 bits) about the name"
    assert next_in_words(replace(first, then=("regrasp-lower", None))) == "regrasp-lower"
    assert next_in_words(replace(first, then=None)) is None


@needs_library
def test_every_touch_has_words() -> None:
    said = {name: touch.done for name, touch in TOUCHES.items()}
    assert len(set(said.values())) == len(TOUCHES)
    assert said["regrasp-lower"] == "gripped it 20 mm lower"
    assert said["regrasp-turned-90"] == "gripped it from 90° round"


@needs_library
def test_each_object_has_its_section_in_the_drawing(sequence: Exploration) -> None:
    contacts = grip_contacts(sequence.touches[0].felt.step.sensed, SETTING.design, SETTING.layout)
    assert set(SECTION_OF) == set(OBJECTS)
    drawings = {name: str(grip_drawing(contacts, name)) for name in (*OBJECTS, "mug")}
    assert all(drawing.count('class="part') == 22 for drawing in drawings.values())
    assert drawings["mug"] == drawings["cylinder"] != drawings["square-pillar"]


def test_a_grip_of_too_few_parts_has_no_section() -> None:
    ends = np.zeros((2, 3)), np.ones((2, 3)) * 0.03
    drawing = str(grip_drawing(GripContacts(("a", "b"), *ends, np.full(2, 0.008), np.array([True, False])), "cone"))
    assert 'class="section' not in drawing
    assert drawing.count('class="part') == 2
    nothing = np.zeros((0, 3))
    assert grip_drawing(GripContacts((), nothing, nothing, np.zeros(0), np.zeros(0, bool)), "cone") is None


@given(st.lists(st.lists(st.floats(0.01, 1), min_size=4, max_size=4), min_size=1, max_size=4), st.booleans())
def test_a_belief_chart_keeps_within_its_frame_and_labels_apart(rows: list[list[float]], narrow: bool) -> None:
    beliefs = [{f"object {k}": p / sum(row) for k, p in enumerate(row)} for row in rows]
    drawn = str(belief_chart(beliefs, ["grasp"] * len(rows), narrow=narrow))
    _, _, width, height = map(float, re.search(r'viewBox="([^"]*)"', drawn)[1].split())
    ends = sorted(float(y) for y in re.findall(r'class="end k\d" x="[^"]*" y="([^"]*)"', drawn))
    assert all(below - above >= 15.8 for above, below in pairwise(ends))
    for x, y in re.findall(r'cx="([^"]*)" cy="([^"]*)"', drawn):
        assert 0 <= float(x) <= width
        assert 0 <= float(y) <= height


def test_a_size_strip_reaches_what_lies_far_off() -> None:
    strip = str(size_strip(0.15, (0.14, 0.2), 0.02))
    x = float(re.search(r'class="true" d="M([0-9.]+) ', strip)[1])
    assert 0 <= x <= 360
    assert size_strip(None, None, 0.05) is None


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32))
def test_a_photo_is_read_back_as_it_was(height: int, width: int, seed: int) -> None:
    cv2 = pytest.importorskip("cv2")
    picture = np.random.default_rng(seed).integers(0, 256, (height, width, 3)).astype(np.uint8)
    png = base64.b64decode(photo_data_uri(picture).removeprefix("data:image/png;base64,"))
    read = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert (read[..., ::-1] == picture).all()


def test_what_is_no_picture_is_named() -> None:
    with pytest.raises(InputError, match=r"must be uint8 of shape \(height, width, 3\), got float64 of shape \(2, 2\)"):
        photo_data_uri(np.zeros((2, 2)))  # type: ignore[arg-type]


def test_a_page_that_cannot_be_written_says_so(tmp_path) -> None:
    with pytest.raises(InputError, match="no/where"):
        write_perceive_report(tmp_path / "no/where/r.html", Exploration("cone", 0.06, 0, (), 9, None))
