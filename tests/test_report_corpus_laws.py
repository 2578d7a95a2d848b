"""The page of a corpus against plain sums over its recordings; its bars read back; its limits at their edges."""

from __future__ import annotations

import html
import re

import numpy as np
import pytest
from tests.reading_svg import box_of, drawn, paths_of

from varishold._counted import counted
from varishold.corpus.summary import Doubtful, FileHealth, NameCount, Sizes, Summary
from varishold.report import render_corpus_report
from varishold.report.quantities import length, number, percent
from varishold.report.size_bars import size_bars


def a_file(k: int, rng: np.random.Generator, **how: object) -> FileHealth:
    n = int(rng.integers(0, 3000))
    found = {
        "n_frames": n,
        "n_contacts": n // 3,
        "n_doubtful": int(rng.integers(0, n // 3 + 1)),
        "n_taxels": 256,
        "n_broken": int(rng.integers(0, 4)),
        "n_lacking": int(rng.integers(0, 9)),
        "duration_s": None if k % 4 == 0 else float(rng.uniform(1, 9000)),
        "says": ("a tap drips",) if k % 3 == 0 else (),
    }
    return FileHealth(f"{k:03}.npz", f"2026-11-{20 + k % 3}" if k % 5 else "", **{**found, **how})  # type: ignore[arg-type]


def a_name(called: str, rng: np.random.Generator, *, metres: bool = True) -> NameCount:
    counts = rng.poisson(2.0, 120) * (np.abs(np.arange(120) - rng.integers(30, 90)) < 9)
    sizes, nothing = Sizes(1e-5 if metres else 1e-1, counts), np.zeros(120, np.int64)
    n = int(counts.sum())
    both = (sizes, Sizes(1e-1, nothing)) if metres else (Sizes(1e-5, nothing), sizes)
    return NameCount(called, n, int(rng.integers(0, n + 1)), int(rng.integers(1, 9)), *both)


def a_doubt(k: int, rng: np.random.Generator, **how: object) -> Doubtful:
    long = float(rng.uniform(0.002, 0.05))
    plain = {"time_s": None if k % 2 else 0.25 * k, "pad": "left", "metres": k % 3 > 0}
    sides = (long, long if k % 4 == 0 else 0.6 * long)
    p = float(rng.uniform(0.1, 0.9))
    found = {"name": "cone", "probability": p, "answer_set": ("hip", "cone", "edge"), "size": sides}
    return Doubtful(f"{k}.npz", 7 * k, k % 3, **{**plain, **found, **how})  # type: ignore[arg-type]


def a_page(summary: Summary, **how: object) -> str:
    return render_corpus_report(summary, title="t", **how)  # type: ignore[arg-type]


def table(page: str, label: str) -> list[list[str]]:
    if f'aria-label="{label}"' not in page:
        return []
    body = page[page.index(f'aria-label="{label}"') :].split("</table>")[0].split("<tbody>")[1]
    rows = re.findall(r"<tr>(.*?)</tr>", body, re.DOTALL)
    return [
        [html.unescape(re.sub(r"<[^>]*>", "", cell)).strip() for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in rows
    ]


def grouped(n: int) -> str:
    """Three digits at a time, from the right."""
    text = str(n)
    parts = [text[max(0, k - 3) : k] for k in range(len(text), 0, -3)]
    return "\u202f".join(reversed(parts))


def lasting(seconds: float) -> str:
    unit, in_it = ("s", 1) if seconds < 120 else ("min", 60) if seconds < 7200 else ("h", 3600)
    return f"{number(seconds / in_it)}\u202f{unit}"


def health_of(files: list[FileHealth]) -> list[str]:
    contacts, broken, lacking = (sum(getattr(f, n) for f in files) for n in ("n_contacts", "n_broken", "n_lacking"))
    lasts = [f.duration_s for f in files if f.duration_s is not None]
    return [
        grouped(sum(f.n_frames for f in files)),
        lasting(sum(lasts)) if lasts else "",
        grouped(contacts),
        percent(sum(f.n_doubtful for f in files) / contacts) if contacts else "",
        f"{grouped(broken)} of {grouped(sum(f.n_taxels for f in files))}" if broken else "",
        grouped(lacking) if lacking else "",
    ]


def facts(page: str) -> dict[str, str]:
    return dict(re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", page[: page.index("</header>")]))


def notes(page: str) -> list[str]:
    return [html.unescape(note) for note in re.findall(r"<li>([^<]*)</li>", page)]


@pytest.mark.parametrize("seed", range(6))
def test_every_table_is_that_of_plain_sums(seed: int) -> None:
    rng = np.random.default_rng(seed)
    files = [a_file(k, rng) for k in range(12)]
    files.append(a_file(12, rng, n_frames=0, n_contacts=0, n_doubtful=0, n_broken=0, n_lacking=0))
    failed = [a_file(k, rng, failure=f"{k}.npz: torn") for k in range(20, 22)]
    names = tuple(a_name(f"name {k}", rng, metres=k != 1) for k in range(3))
    summary = Summary(names, (), (*failed, *files))
    page = a_page(summary)
    total = sum(name.n for name in names)
    assert facts(page) == {
        "recordings": "13",
        "frames": grouped(sum(f.n_frames for f in files)),
        "contacts": grouped(total),
        "duration": lasting(sum(f.duration_s or 0 for f in files)),
        "days": "3, 2026-11-20 to 2026-11-22",
    }
    assert f"<h2>{grouped(total)} contacts</h2>" in page
    for row, name in zip(table(page, "Names and sizes"), names, strict=True):
        sizes, metres = (name.metres, True) if name.metres.n else (name.taxels, False)
        low, middle, high = (float(f"{sizes.quantile(q):.1e}") for q in (0.05, 0.5, 0.95))
        ends = [length(end, metres=metres) for end in (low, high)]
        assert row == [
            name.name,
            grouped(name.n),
            str(name.n_files),
            percent(name.n_sure / name.n),
            length(middle, metres=metres),
            " to ".join(dict.fromkeys(ends)),
            "",
        ]
    shares = [float(p) for p in re.findall(r'style="--p: ([\d.]+)"', page)]
    assert shares == pytest.approx([name.n / total for name in names], abs=1e-4)
    share = lambda part, whole: part / whole if whole else 0  # noqa: E731
    trouble = {
        f.file: share(f.n_broken, f.n_taxels) + share(f.n_lacking, f.n_frames) + share(f.n_doubtful, f.n_contacts)
        for f in files
    }
    by_name = {f.file: f for f in files}
    rows = table(page, "Health by file")
    assert [row[0] for row in rows] == sorted(trouble, key=lambda name: (-trouble[name], name))
    for row in rows:
        says = "A tap drips." if by_name[row[0]].says else ""
        assert row[1:] == [*health_of([by_name[row[0]]]), says]
    for row, day in zip(table(page, "Health by day"), ("2026-11-20", "2026-11-21", "2026-11-22"), strict=True):
        mine = [f for f in files if f.day == day]
        assert row == [day, str(len(mine)), *health_of(mine)]
    doubtful = sum(f.n_doubtful for f in files) / sum(f.n_contacts for f in files)
    torn, other, below, spacing = notes(page)
    assert (torn, other) == ("Not in the table: 20.npz: torn.", "Not in the table: 21.npz: torn.")
    assert below.startswith(f"{percent(doubtful)} of the contacts have a name below 90\u202f%")
    assert spacing.startswith("The spacing of taxels is not known of every recording")


def test_what_there_is_nothing_of_is_not_told() -> None:
    rng = np.random.default_rng(0)
    bare = a_file(1, rng, n_doubtful=0, duration_s=None)
    page = a_page(Summary((a_name("cone", rng),), (), (bare,)))
    assert notes(page) == []
    assert set(facts(page)) == {"recordings", "frames", "contacts", "days"}
    assert facts(page)["days"] == bare.day
    assert table(page, "Health by day")[0][0] == bare.day
    alone = a_page(Summary((), (), (a_file(5, rng),)))
    assert "days" not in facts(alone)
    assert "<h2>0 contacts</h2>" in alone
    unsized = NameCount("edge", 3, 3, 1, Sizes(1e-5, np.zeros(120, np.int64)), Sizes(1e-1, np.zeros(120, np.int64)))
    assert table(a_page(Summary((unsized,), (), ())), "Names and sizes") == [
        ["edge", "3", "1", "100\u202f%", "–", "", ""]
    ]


@pytest.mark.parametrize(
    ("seconds", "told"),
    [(119.9, "120\u202fs"), (120.0, "2\u202fmin"), (7199.0, "120\u202fmin"), (7200.0, "2\u202fh"), (9e4, "25\u202fh")],
)
def test_a_duration_is_told_in_the_unit_that_suits_it(seconds: float, told: str) -> None:
    page = a_page(Summary((), (), (a_file(1, np.random.default_rng(0), duration_s=seconds),)))
    assert facts(page)["duration"] == told
    assert table(page, "Health by file")[0][2] == told


@pytest.mark.parametrize("n", [11, 12, 13, 30])
def test_a_dozen_failures_are_told_one_by_one(n: int) -> None:
    rng = np.random.default_rng(0)
    page = a_page(Summary((), (), tuple(a_file(k, rng, failure=f"{k} is torn") for k in range(n))))
    told = notes(page)
    assert told[:12] == [f"Not in the table: {k} is torn." for k in range(min(n, 12))]
    assert len(told) == min(n, 13)
    if n > 12:
        assert told[12].startswith(f"{counted(n - 12, 'more recording is', 'more recordings are')} not in the table")


@pytest.mark.parametrize("n", [399, 400, 401])
def test_files_are_listed_up_to_four_hundred(n: int) -> None:
    rng = np.random.default_rng(0)
    page = a_page(Summary((), (), tuple(a_file(k, rng) for k in range(n))))
    assert len(table(page, "Health by file")) == min(n, 400)
    assert re.findall(r"(\d+) more recording is not listed", page) == (["1"] if n > 400 else [])


@pytest.mark.parametrize("pads", [("left",), ("left", "right")])
def test_doubtful_contacts_are_told_as_they_are(pads: tuple[str, ...]) -> None:
    rng = np.random.default_rng(1)
    doubts = tuple(a_doubt(k, rng, pad=pads[k % len(pads)]) for k in range(9))
    page = a_page(Summary((), doubts, ()), look=lambda file, frame: f"look {frame} in {file}")
    for row, one in zip(table(page, "Doubtful contacts"), doubts, strict=True):
        long, short = (length(side, metres=one.metres) for side in one.size)
        assert row == [
            "cone",
            percent(one.probability),
            "hip, edge",
            long if one.size[0] == one.size[1] else f"{long} × {short}",
            one.file,
            str(one.frame),
            "" if one.time_s is None else f"{one.time_s:.2f}\u202fs",
            *([one.pad] if len(pads) > 1 else []),
            str(one.contact),
        ]
    shares = [float(p) for p in re.findall(r'style="--p: ([\d.]+)"', page)]
    assert shares == pytest.approx([one.probability for one in doubts], abs=1e-4)
    assert "<code>look 0 in 0.npz</code>" in page
    assert "<code>" not in a_page(Summary((), doubts, ()))
    assert "look" not in a_page(Summary((), (), ()), look=lambda file, frame: 1 / 0)  # type: ignore[arg-type,return-value]


@pytest.mark.parametrize("seed", range(12))
def test_bars_stand_side_by_side_as_high_as_their_counts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    counts = np.zeros(120, np.int64)
    # Ends, few and many.
    first = (0, 40, 100, 117)[seed % 4]
    last = min(119, first + (0, 3, 11, 60)[seed // 3])
    counts[first : last + 1] = rng.integers(0, 50, last + 1 - first)
    counts[last], counts[first] = 1, 1000
    root = drawn(size_bars(counts, label="how often"))
    _, _, wide, high = map(float, root.get("viewBox", "").split())
    assert (wide, high) == (120, 26)
    (path,) = root.iter("path")
    boxes = [(*part.min(axis=0), *part.max(axis=0)) for part in paths_of(path.get("d"))]
    there = np.flatnonzero(counts)
    # An empty step on each side, where there is one, and no fewer than twelve.
    begin, end = max(0, first - 1), min(120, last + 2)
    step = 120 / max(end - begin, 12)
    left = (120 - step * (end - begin)) / 2
    for k, (x0, y0, x1, y1) in zip(there, boxes, strict=True):
        assert (x0 + x1) / 2 == pytest.approx(left + (k - begin + 0.5) * step, abs=0.11)
        assert x1 - x0 == pytest.approx(0.8 * step, abs=0.06)
        assert y1 == 26
        assert y1 - y0 == pytest.approx(max(1.5, 26 * counts[k] / 1000), abs=0.06)
    box = box_of(root, path)
    assert 0 <= box[0] < box[2] <= 120
    assert root.get("aria-label") == "how often"
