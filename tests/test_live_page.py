"""The page as a person sees it, in a headless Chromium."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.live_presses import Pressing
from tests.live_scripted import Scripted, wait_until
from tests.test_live_believer import library

from benchmarks._chromium import Chromium, chromium_program
from varishold import read
from varishold.errors import LostSourceError
from varishold.live import PadLayout, source_at
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.perceive import Perceiver

pytestmark = pytest.mark.skipif(chromium_program() is None, reason="there is no Chromium here")

TEXT = "document.getElementById('{}').innerText"
# How many colours a canvas shows: one that is empty shows one.
COLOURS = """(() => {{
  const c = document.getElementById('{}'), seen = new Set();
  const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
  for (let k = 0; k < d.length; k += 4) seen.add(d[k] << 16 | d[k + 1] << 8 | d[k + 2]);
  return seen.size;
}})()"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Chromium]:
    with Chromium(1240, 900) as chromium:
        yield chromium
        # A page whose server is gone tries again and again, and the browser says so.
        assert [told for told in chromium.problems if "WebSocket" not in told] == []


def test_what_touches_is_drawn_and_named_with_its_reasons(browser: Chromium) -> None:
    with Session(source_at("sim:cone?rest_s=1.3&hold_s=60&moves=0")) as session, PageServer(session, port=0) as server:
        browser.open(server.address)
        browser.wait(f"{TEXT.format('name')}.toLowerCase() === 'cone'")
        browser.wait(f"{TEXT.format('reasons')}.includes('shrink')")
        browser.wait(f"{TEXT.format('events')}.includes('touched')")
        for canvas in ("frame", "outlines", "solid", "chord-0", "chord-1", "course"):
            browser.wait(f"{COLOURS.format(canvas)} > 5")
        assert "90 % are held by" in browser.value(TEXT.format("held"))
        assert "16 × 16 at 2" in browser.value(TEXT.format("health"))
        assert browser.value("document.getElementById('bars').children.length") >= 3
        # What is drawn is not told otherwise to those who cannot see it.
        said = "[...document.querySelectorAll('canvas')].map(c => c.ariaLabel || c.closest('button').innerText)"
        assert all(browser.value(said))


def test_buttons_and_keys_ask_and_the_answer_is_shown(browser: Chromium) -> None:
    with Session(source_at("sim:cone?rest_s=60")) as session, PageServer(session, port=0) as server:
        browser.open(server.address)
        browser.wait("window.varisholdLive && varisholdLive.drawn > 3")
        browser.wait(f"{TEXT.format('events')}.includes('zero taken')")
        browser.press("z")
        browser.wait(f"{TEXT.format('said')} === 'zero asked for'")
        browser.wait(f"{TEXT.format('events')}.split('zero taken').length === 3")
        browser.press("p")
        time.sleep(0.3)
        held = browser.value("varisholdLive.drawn")
        time.sleep(0.3)
        assert browser.value("varisholdLive.drawn") == held
        browser.press("p")
        browser.wait(f"varisholdLive.drawn > {held + 5}")
        browser.value("document.getElementById('learn').disabled = false; document.getElementById('learn').click()")
        browser.wait(f"{TEXT.format('said')}.includes('two labels or more')")


def test_recording_is_begun_and_ended_at_the_page(browser: Chromium, tmp_path: Path) -> None:
    with (
        Session(source_at("sim:cone?rest_s=60"), folder=tmp_path) as session,
        PageServer(session, port=0) as server,
    ):
        browser.open(server.address)
        browser.wait("!document.getElementById('record').hidden")
        browser.press("r")
        browser.wait(f"/Stop recording .[1-9]/.test({TEXT.format('record')})")
        browser.value("document.getElementById('record').click()")
        browser.wait(f"{TEXT.format('events')}.includes('readings in')")
        browser.wait(f"{TEXT.format('record')} === 'Record'")
    (file,) = tmp_path.glob("*.mcap")
    assert read(file).n_frames > 3


def test_things_are_taught_at_the_page_and_recognized(browser: Chromium) -> None:
    pressing = Pressing()
    with pressing.session as session, PageServer(session, port=0) as server:
        browser.open(server.address)
        for label in ("cone", "pillar"):
            browser.value(
                f"document.getElementById('label').value = '{label}'; document.getElementById('keep').click()"
            )
            browser.wait(f"document.querySelector('#kept .now') && {TEXT.format('kept')}.includes('{label}')")
            pressing.press(*[label] * 10)
            browser.wait(f"{TEXT.format('kept')}.includes('●●●●●●●●●● 10')")
            browser.value("document.getElementById('keep').click()")
            browser.wait("document.getElementById('keep').getAttribute('aria-pressed') === 'false'")
        browser.value("document.getElementById('learn').click()")
        browser.wait(f"{TEXT.format('taught')}.includes('learned 2 things from 20 presses')")
        for label in ("pillar", "cone"):
            pressing.press(label, seed=5)
            browser.wait(f"{TEXT.format('named-name')} === '{label}'")
        browser.wait(f"{TEXT.format('events')}.includes('cone, ')")
        assert "Most like" in browser.value(TEXT.format("named-reasons"))


CLICK_AT_ONCE = """(() => {
    const keep = document.getElementById("keep");
    if (!keep || !window.varisholdLive) return false;
    document.getElementById("label").value = "cone";
    keep.click();
    return true;
})()"""


def test_what_is_clicked_while_the_page_connects_is_done(browser: Chromium) -> None:
    pressing = Pressing()
    with pressing.session as session, PageServer(session, port=0) as server:
        for _ in range(5):
            browser.open("about:blank")
            browser.call("Page.navigate", url=server.address)
            browser.wait(CLICK_AT_ONCE)
            browser.wait("document.getElementById('keep').getAttribute('aria-pressed') === 'true'")
            browser.value("document.getElementById('keep').click()")
            browser.wait("document.getElementById('keep').getAttribute('aria-pressed') === 'false'")


def test_an_object_is_known_by_several_presses(browser: Chromium) -> None:
    pressing = Pressing(model=Perceiver(library(), least_touches=2, most_touches=2, refuse=False))
    with pressing.session as session, PageServer(session, port=0) as server:
        browser.open(server.address)
        pressing.press("cone")
        browser.wait(f"{TEXT.format('named-name')} === 'cone'")
        assert browser.value("document.getElementById('save').hidden")
        pressing.press("cone", seed=3)
        browser.wait(f"{TEXT.format('named-when')}.includes('2 presses of it')")
        browser.value("document.getElementById('next').click()")
        browser.wait(f"{TEXT.format('said')} === 'the next press is of another object'")


def test_labels_are_text_whatever_they_hold(browser: Chromium) -> None:
    with Session(source_at("sim:cone?rest_s=60")) as session, PageServer(session, port=0) as server:
        browser.open(server.address)
        browser.wait("window.varisholdLive && varisholdLive.drawn > 3")
        label = "<img src=x onerror=alert(1)>"
        browser.value(f"document.getElementById('label').value = '{label}'; document.getElementById('keep').click()")
        browser.wait(f"{TEXT.format('kept')}.includes('{label}')")
        assert browser.value("document.querySelectorAll('#kept img').length") == 0
        assert browser.value("document.getElementById('keep').getAttribute('aria-pressed')") == "true"


def test_a_lost_source_and_a_lost_server_are_told_and_come_back(browser: Chromium) -> None:
    source = Scripted()
    with Session(source) as session:
        with PageServer(session, port=0) as server:
            port = int(server.address.rsplit(":", 1)[1].strip("/"))
            browser.open(server.address)
            wait_until(lambda: session.stream.state == "open")
            source.there = False
            source.script.put(LostSourceError("scripted:: is gone"))
            browser.wait(f"{TEXT.format('trouble')}.includes('scripted')")
            source.there = True
            browser.wait(f"!{TEXT.format('trouble')}.includes('scripted')")
        browser.wait(f"{TEXT.format('trouble')}.includes('No connection')")
        with PageServer(session, port=port):
            browser.wait(f"!{TEXT.format('trouble')}.includes('No connection')")


def test_several_pads_each_have_a_frame_that_can_be_chosen(browser: Chromium) -> None:
    with Session(source_at("sim:sphere?pads=3&rest_s=1.2&hold_s=30")) as session, PageServer(session, port=0) as server:
        browser.open(server.address)
        browser.wait("document.querySelectorAll('#pads button').length === 3")
        browser.wait("document.querySelectorAll('#tracks button').length === 3")
        browser.value("document.querySelectorAll('#pads button')[1].click()")
        browser.wait("document.querySelectorAll('#pads button')[1].getAttribute('aria-pressed') === 'true'")
        browser.wait(f"{TEXT.format('place')}.startsWith('pad2')")


def test_each_of_many_contacts_is_spoken_of_when_it_is_looked_at(browser: Chromium) -> None:
    with (
        Session(source_at("sim:sphere?pads=8&rest_s=1.2&hold_s=60&shape=10x10&moves=0")) as session,
        PageServer(session, port=0) as server,
    ):
        browser.open(server.address)
        browser.wait("document.querySelectorAll('#tracks button').length === 8")
        for k in range(1, 9):
            browser.value(f"document.querySelector('#pads button[data-pad=\"pad{k}\"]').click()")
            browser.wait(f"{TEXT.format('place')}.startsWith('pad{k} ') && {TEXT.format('place')}.includes('looks')")
            browser.wait(f"{TEXT.format('reasons')}.length > 20")


def test_signals_are_drawn_as_lines(browser: Chromium) -> None:
    import numpy as np

    from varishold.live import Sample

    source = Scripted()
    source.pads = {"field": PadLayout((3,), kind="signals", names=("x", "y", "z"))}
    with Session(source) as session, PageServer(session, port=0) as server:
        browser.open(server.address)
        for k in range(40):
            source.script.put(Sample(k / 20, time.time(), k, {"field": np.sin(k / 5 + np.arange(3.0))}))
            time.sleep(0.02)
        browser.wait("document.querySelectorAll('.signals-plot').length === 1")
        assert browser.value("document.getElementById('card').hidden")


@pytest.mark.parametrize("width", [390, 1240])
def test_nothing_sticks_out_at_the_side(width: int) -> None:
    with (
        Session(source_at("sim:sphere?pads=8&rest_s=1.2&hold_s=30")) as session,
        PageServer(session, port=0) as server,
        Chromium(width, 800, dark=True) as chromium,
    ):
        chromium.open(server.address)
        chromium.wait("document.querySelectorAll('#tracks button').length === 8")
        assert chromium.value("document.documentElement.scrollWidth") <= width
        assert chromium.problems == []
