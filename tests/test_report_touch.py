"""The page of `varishold touch`: sound, self-contained, deterministic, safe, and alive in a browser."""

from __future__ import annotations

import html.parser
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.recording.pad import Pad
from varishold.recording.recording import Recording
from varishold.report import render_touch_report, write_touch_report
from varishold.report.touch_report import MOST_CARDS
from varishold.touch import KINDS, Answer, find_contacts
from varishold.touch.decision import Parameters
from varishold.touch.signature import SIGNATURE_GROUPS
from varishold.touch.surface import Surface

HOSTILE = """</script><script>alert(1)</script><img src=x onerror=alert(2)>"'&{{ 7 * 6 }}"""
_N = len(SIGNATURE_GROUPS)
_K = len(KINDS)
_SPREAD = np.zeros((_K, 2, 2, 1 + _N))
_SPREAD[:, :, 1, 0] = np.log(0.4)

BLANK = Parameters(
    shift=np.zeros(_N),
    scale=np.ones(_N),
    clip=5.0,
    weights=(np.zeros((_N, 2), np.float32), np.zeros((2, 2), np.float32), np.zeros((2, _K), np.float32)),
    biases=(np.zeros(2, np.float32), np.zeros(2, np.float32), np.zeros(_K, np.float32)),
    kind_means=np.zeros((_K, _N)),
    size_spread=_SPREAD,
    map_spread=_SPREAD,
)


def dome(shape=(24, 24), centre=(11.5, 11.5), radius=8.0, height=900.0):
    """A parabolic bump on an empty pad."""
    y, x = np.mgrid[: shape[0], : shape[1]]
    r2 = (y - centre[0]) ** 2 + (x - centre[1]) ** 2
    return height * np.maximum(1 - r2 / radius**2, 0.0)


def ring(shape=(24, 24), radius=7.0, width=2.5, height=900.0):
    """A ridge along a circle, as under a flat punch."""
    y, x = np.mgrid[: shape[0], : shape[1]]
    r = np.hypot(y - (shape[0] - 1) / 2, x - (shape[1] - 1) / 2)
    return height * np.maximum(1 - ((r - radius) / width) ** 2, 0.0)


def surface_of(contact, key="sphere", share=0.9):
    """A surface of the kind `key`, called so without asking a table."""
    at = next(i for i, kind in enumerate(KINDS) if kind.key == key)
    p = np.full(_K, (1 - share) / (_K - 1))
    p[at] = share
    kind = KINDS[at]
    name_share = float(sum(q for q, other in zip(p, KINDS, strict=True) if other.name == kind.name))
    return Surface(
        contact=contact,
        name=kind.name,
        form=kind.form,
        section=kind.section,
        probability=name_share,
        kind_probability=p,
        inputs=np.zeros(_N),
        parameters=BLANK,
    )


def recording_of(frames, *, name="pad", time=True, **options):
    """A recording of one pad."""
    frames = np.asarray(frames)
    pad_options = {key: options.pop(key) for key in ("valid", "field", "pitch_m") if key in options}
    times = np.arange(len(frames)) * 0.1 if time else None
    return Recording({name: Pad(frames, **pad_options)}, time_s=times, **options)


def answers_of(recording, key="sphere"):
    """One answer for every contact of every frame."""
    found = []
    for name, pad in recording.pads.items():
        for i in range(pad.n_frames):
            contacts = find_contacts(
                np.asarray(pad.frames[i], float), pitch=pad.pitch_m, valid=pad.valid, field=pad.field
            )
            for number, contact in enumerate(contacts):
                time = None if recording.time_s is None else float(recording.time_s[i])
                found.append(
                    Answer(
                        file=recording.source or None,
                        frame=i,
                        time_s=time,
                        pad=name,
                        contact=number,
                        surface=surface_of(contact, key),
                        unit=recording.unit,
                        pascals_per_unit=recording.pascals_per_unit,
                        pitch_m=pad.pitch_m,
                    )
                )
    return found


class Page(html.parser.HTMLParser):
    """Reads a page strictly: every element that is opened is closed, in order."""

    VOID = ("meta", "link", "img", "input", "br", "hr")

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.attributes, self.text = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes.append((tag, dict(attrs)))
        assert len({name for name, _ in attrs}) == len(attrs), f"an attribute twice in {tag}"
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.text.append(data)

    def attributes_of(self, style):
        return [attributes for _, attributes in self.attributes if attributes.get("class") == style]

    @property
    def words(self):
        return " ".join(" ".join(self.text).split())


@pytest.fixture(scope="module")
def pressed():
    """Three frames: a dome, a ring, and two domes of which one lies at the border."""
    two = dome(centre=(6.0, 6.0), radius=5) + dome(centre=(17.0, 23.0), radius=6, height=500.0)
    noise = np.random.default_rng(5).normal(scale=4.0, size=(3, 24, 24))
    valid = np.ones((24, 24), bool)
    valid[3, 20] = valid[11, 11] = False
    return recording_of(
        np.array([dome(), ring(), two]) + noise, valid=valid, pitch_m=(0.002, 0.003), unit="Pa", sensor="skin"
    )


@pytest.fixture(scope="module")
def page(pressed):
    return render_touch_report(answers_of(pressed), recording=pressed, title="Three frames")


def test_the_page_is_balanced_and_its_names_are_unique(page):
    read = Page(page)
    ids = [attributes["id"] for _, attributes in read.attributes if "id" in attributes]
    assert len(ids) == len(set(ids))
    inner = [a["href"] for tag, a in read.attributes if tag == "a"]
    assert inner
    assert all(link[0] == "#" and link[1:] in ids for link in inner)


def test_the_page_asks_for_nothing_from_outside(page):
    assert not re.search(r"https?:|@import|//[a-z]+\.", page)
    for tag, attributes in Page(page).attributes:
        for name in ("src", "href", "action", "data", "poster", "srcset", "xlink:href"):
            if attributes.get(name):
                assert attributes[name].startswith(("data:", "#")), (tag, attributes[name][:60])
    assert set(re.findall(r"url\(([^)]*)\)", page)) == {"#hatch"}


def test_every_picture_is_told_in_words(page):
    for tag, attributes in Page(page).attributes:
        if tag == "svg" and attributes.get("aria-hidden") != "true":
            assert attributes["role"] == "img"
            assert len(attributes["aria-label"]) > 20
        if tag == "img":
            assert "alt" in attributes


def test_the_page_tells_names_numbers_and_cautions(page):
    words = Page(page).words
    for said in (
        "Three frames",
        "sphere",
        "90 %",
        "2 taxels are marked broken ((row, col) = (3, 20), (11, 11))",
        "The skin is not known",
        "frame 1",
        "noise σ",
        "bulge",
    ):
        assert said in words
    assert not re.search(r"\b(nan|None|inf)\b", words)


def test_the_same_answers_give_the_same_bytes(pressed, page):
    assert render_touch_report(answers_of(pressed), recording=pressed, title="Three frames") == page


def test_hostile_names_stay_text():
    recording = recording_of([dome()], name=HOSTILE, unit=HOSTILE, sensor=HOSTILE, source=f"/tmp/{HOSTILE}")
    answers = answers_of(recording)
    answers[0].surface.__dict__["reasons"] = (HOSTILE,)
    recording = Recording(
        {**recording.pads, "other": recording.pads[HOSTILE]},
        unit=HOSTILE,
        sensor=HOSTILE,
        source=HOSTILE,
        notes=(HOSTILE,),
    )
    for title in (None, HOSTILE):
        text = render_touch_report(answers, recording=recording, title=title, skin=HOSTILE)
        read = Page(text)
        assert read.tags.count("script") == 1
        assert text.count("<img") == 0
        assert "alert(1)" in read.words
        assert "{{ 7 * 6 }}" in text or "{{ 7 * 6 }}" in read.words
        assert not any(name.startswith("on") for _, attributes in read.attributes for name in attributes)


def test_levels_can_be_read_back(page):
    sweeps = [a for _, a in Page(page).attributes if a.get("class") == "sweep"]
    for sweep in sweeps:
        levels, scene = json.loads(sweep["data-levels"]), json.loads(sweep["data-scene"])
        heights = [level[0] for level in levels]
        assert heights == sorted(heights, reverse=True)
        assert all(0 <= height <= 1 for height in heights)
        assert scene["rows"] * scene["cols"] > 0


def test_many_contacts_stay_a_few_megabytes():
    frames = np.array([dome(centre=(12.0, 8.0 + 0.02 * i)) for i in range(300)])
    recording = recording_of(frames + np.random.default_rng(1).normal(scale=4.0, size=frames.shape))
    answers = answers_of(recording)
    text = render_touch_report(answers, recording=recording)
    assert len(text.encode()) < 4_000_000
    assert text.count('<article class="card"') == MOST_CARDS
    assert f"{len(answers)} contacts were found" in Page(text).words


def test_a_large_frame_stays_small():
    recording = recording_of([dome((240, 320), (120.0, 160.0), 90.0)])
    assert len(render_touch_report(answers_of(recording), recording=recording).encode()) < 300_000


def test_no_contact_is_said():
    recording = recording_of(np.zeros((2, 4, 4)), time=False)
    words = Page(render_touch_report([], recording=recording)).words
    assert "No contact" in words


@pytest.mark.parametrize("key", [kind.key for kind in KINDS])
def test_every_kind_has_its_card(key):
    recording = recording_of([dome()], pitch_m=0.002)
    Page(render_touch_report(answers_of(recording, key), recording=recording))


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 2), (3, 40)])
def test_pads_of_any_shape(shape):
    frame = np.zeros(shape)
    frame[shape[0] // 2, shape[1] // 2] = 5.0
    frame[-1, -1] = 7.0
    recording = recording_of([frame])
    Page(render_touch_report(answers_of(recording), recording=recording))


def test_gaps_of_the_field_and_height_maps():
    field = np.ones((24, 24), bool)
    field[8:12, 9:20] = False
    frames = np.where(field, dome(height=0.002), np.nan)
    recording = recording_of([frames], field=field, pitch_m=0.001, unit="m")
    words = Page(render_touch_report(answers_of(recording), recording=recording)).words
    assert "depth 1.98 mm" in words
    assert "The skin is not known" not in words


def test_the_file_is_written_whole(tmp_path, pressed, page):
    path = tmp_path / "report.html"
    write_touch_report(path, iter(answers_of(pressed)), recording=pressed, title="Three frames")
    assert path.read_text(encoding="utf-8") == page
    with pytest.raises(InputError, match="make it first"):
        write_touch_report(tmp_path / "nowhere" / "report.html", [], recording=pressed)


def browse(address, profile):
    """Open a page in Chromium; return its document after the script has run, and what was logged."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("no chromium here to open the page with")
    command = [
        *(browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"),
        *("--disable-background-networking", "--disable-component-update", "--disable-quic"),
        *("--enable-logging=stderr", "--virtual-time-budget=2000", f"--user-data-dir={profile}", "--dump-dom", address),
    ]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)
    except (subprocess.TimeoutExpired, OSError) as error:
        pytest.skip(f"chromium does not run here: {error}")
    if "</html>" not in done.stdout:
        pytest.skip(f"chromium does not run here: {done.stderr.strip()[-200:]}")
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def rims(card):
    """Return the bounding box of each slab's top, in screen units, from the lowest up."""
    solid = card[card.index('class="screen solid"') :]
    solid = solid[: solid.index("</svg>")]
    steps = 10 if 'class="turn" transform="scale(0.1)"' in solid else 1
    boxes = []
    for d in re.findall(r'class="rim" fill="[^"]*" d="([^"]*)"', solid):
        corners = []
        for part in d.split("M")[1:]:
            n = np.array([float(k) for k in re.findall(r"-?[\d.]+", part)]).reshape(-1, 2) / steps
            corners.append(np.cumsum(n, axis=0) if "l" in part else n)
        corners = np.concatenate(corners)
        boxes.append([*corners.min(axis=0), *corners.max(axis=0)])
    return np.array(boxes)


def test_the_script_draws_the_stack_that_the_page_holds(tmp_path, page):
    path = tmp_path / "report.html"
    path.write_text(page, encoding="utf-8")
    document, _ = browse(f"{path.as_uri()}#c1/999", tmp_path / "profile")
    held, drawn = (rims(text.split('<article class="card"')[1]) for text in (page, document))
    assert 'transform="scale(0.1)"' not in document.split('<article class="card"')[1]
    assert held.shape == drawn.shape
    assert np.abs(held - drawn).max() < 0.5


def test_the_threshold_moves_in_a_browser(tmp_path, page):
    path = tmp_path / "report.html"
    path.write_text(page, encoding="utf-8")
    document, logged = browse(f"{path.as_uri()}#c2/5", tmp_path / "profile")
    assert logged == []
    cards = document.split('<article class="card"')[1:]
    assert all('type="range"' in card and "Surface</button>" in card for card in cards)
    moved = cards[1]
    assert 'data-level="5"' in moved
    assert "X₆" in moved
    outlines = moved[moved.index('class="screen outlines"') :]
    outlines = outlines[: outlines.index("</svg>")]
    assert outlines.count("level wait") == len(json.loads(Page(page).attributes_of("sweep")[1]["data-levels"])) - 6
    assert outlines.count("level here") == 1
    assert "data-level=" not in cards[0]
