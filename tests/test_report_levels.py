"""What was done to a frame, and both levels of an answer, on the page and in the printed table."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.test_report_touch import HOSTILE, Page, answers_of, dome, recording_of, surface_of

from varishold.cli.printing import print_answers
from varishold.levelset.contact import with_losses
from varishold.report import render_touch_report
from varishold.touch import find_contacts
from varishold.touch.names import KINDS, OUTLINE_OF

ZEROED, FILLED = "zeroed on frames 0 to 4, before the first touch", "2 broken taxels filled from the neighbours"


def faulty(share=0.9, key="sphere"):
    """A recording of two contacts, the first of which is cut, saturated and has a broken taxel."""
    recording = recording_of([dome(centre=(8.0, 0.0)), dome()], sensor="mat")
    first, second = answers_of(recording, key)
    saturated, broken = np.zeros((2, 24, 24), bool)
    saturated[7:10, :2] = broken[8, 3] = True
    (contact,) = with_losses(find_contacts(dome(centre=(8.0, 0.0))), saturated=saturated, repaired=broken)
    first = replace(
        first, surface=surface_of(contact, key, share), sensor="mat.toml", frame_notes=(ZEROED, FILLED, HOSTILE)
    )
    return recording, [first, replace(second, sensor="mat.toml", frame_notes=(ZEROED,))]


def test_what_was_done_to_all_frames_is_said_once_and_the_rest_with_its_contact():
    recording, answers = faulty()
    text = render_touch_report(answers, recording=recording)
    cards = text.split('<article class="card"')
    assert Page(text).words.count(ZEROED[1:]) == 1
    assert [card.count(ZEROED[1:]) for card in cards] == [1, 0, 0]
    assert [card.count(FILLED) for card in cards] == [0, 1, 0]
    assert "undone as mat.toml" in Page(text).words


def test_what_the_sensor_lost_is_marked_in_the_frame_and_told():
    recording, answers = faulty()
    _, first, second = render_touch_report(answers, recording=recording).split('<article class="card"')
    drawn = {mark: re.search(f'class="{mark}" d="([^"]*)"', first)[1] for mark in ("dead", "full", "ends")}
    assert [drawn[mark].count("M") for mark in ("dead", "full", "ends")] == [2, 12, 1]
    for said in ("× broken and filled", "^ saturated", "orange border: cut there", "cut by the pad", "left"):
        assert said in first
        assert said == "left" or said not in second
    assert not any(f'class="{mark}"' in second for mark in drawn)


def test_a_plane_is_not_said_to_be_cut():
    recording, answers = faulty(key="plane")
    assert answers[0].surface.cut
    words = Page(render_touch_report(answers, recording=recording)).words
    assert "cut by" not in words
    assert "cut there" not in words


def test_marks_that_would_hide_the_frame_are_left_out():
    recording = recording_of([dome((120, 120), (60.0, 60.0), 50.0)])
    (answer,) = answers_of(recording)
    everywhere = np.ones((120, 120), bool)
    (contact,) = with_losses([answer.surface.contact], saturated=everywhere)
    text = render_touch_report([replace(answer, surface=surface_of(contact))], recording=recording)
    assert 'class="full"' not in text
    assert "^ saturated" not in text


@pytest.mark.parametrize("key", [kind.key for kind in KINDS])
@pytest.mark.parametrize("share", [0.4, 0.95])
def test_a_card_tells_both_levels_of_the_answer(key, share):
    recording, answers = faulty(share, key)
    surface = answers[0].surface
    words = Page(render_touch_report(answers[:1], recording=recording)).words
    assert surface.outline == OUTLINE_OF[surface.name]
    assert f"outline {surface.outline}, {100 * surface.outline_probability:.3g}" in words.replace("\u202f", " ")
    alone = " alone" if len(surface.answer_set) == 1 else ""
    assert f"90 % are held by {', '.join(surface.answer_set)}{alone}." in words
    assert "Probability of the outline" in words


def test_hostile_notes_and_sensors_stay_text():
    recording, answers = faulty()
    answers[0] = replace(answers[0], sensor=HOSTILE)
    read = Page(text := render_touch_report(answers, recording=recording))
    assert read.tags.count("script") == 1
    assert text.count("<img src=x") == 0
    assert read.words.count("alert(1)") == 2


def test_the_printed_table_says_notes_once_and_the_set_where_the_name_is_unsure(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    recording, answers = faulty(0.4)
    answers[1] = replace(answers[1], surface=surface_of(answers[1].surface.contact, share=0.97))
    print_answers(answers, recording, json=False)
    lines = capsys.readouterr().out.splitlines()
    assert sum(ZEROED in line for line in lines) == 1
    assert f"note: {FILLED} (1 of 2 contacts)" in lines
    unsure = [line.strip() for line in lines if "90 %:" in line]
    names = answers[0].surface.answer_set
    assert len(unsure) == 1
    assert unsure[0].startswith(
        f"outline round {answers[0].surface.outline_probability:.2f}; 90 %: {', '.join(names[:4])}"
    )
    assert unsure[0].endswith(f"and {len(names) - 4} more; cut at the pad's left")


def test_many_kinds_of_notes_are_only_counted_in_the_table(capsys):
    recording, answers = faulty()
    answers = [replace(answers[0], frame_notes=tuple(f"note {i}" for i in range(20)))]
    print_answers(answers, recording, json=False)
    out = capsys.readouterr().out
    assert "note 7" in out
    assert "note 8" not in out
    assert "12 more notes on frames; --json has them" in out
