"""The page of a corpus: what it counts, what it warns of, and that nothing in it comes from outside."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.corpus_recordings import recording

from varishold.cli import main
from varishold.corpus.summary import Doubtful, FileHealth, NameCount, Sizes, Summary
from varishold.recording import write
from varishold.report import render_corpus_report, write_corpus_report
from varishold.report.size_bars import size_bars


def counts(*pairs: tuple[int, int]) -> np.ndarray:
    made = np.zeros(120, np.int64)
    for step, n in pairs:
        made[step] = n
    return made


NOTHING = counts()


def name(called: str, n: int, metres: np.ndarray = NOTHING, taxels: np.ndarray = NOTHING) -> NameCount:
    return NameCount(called, n, n // 2, 2, Sizes(1e-5, metres), Sizes(1e-1, taxels))


def file(called: str, day: str = "", **how: object) -> FileHealth:
    plain = {"n_frames": 1000, "n_contacts": 10, "n_doubtful": 1, "n_taxels": 64, "n_broken": 0, "n_lacking": 0}
    return FileHealth(called, day, **{**plain, "duration_s": 10.0, "says": (), **how})  # type: ignore[arg-type]


def page_of(*files: FileHealth, names: tuple[NameCount, ...] = (), doubtful: tuple[Doubtful, ...] = ()) -> str:
    return render_corpus_report(
        Summary(names, doubtful, files), title="names.parquet", look=lambda file, frame: f"see {file!r} at {frame}"
    )


def cells(page: str, about: str) -> list[list[str]]:
    """Return the texts of a table's cells, row by row."""
    table = page[page.index(f'aria-label="{about}"') :].split("</table>")[0]
    rows = re.findall(r"<tr>(.*?)</tr>", table.split("<tbody>")[1], re.DOTALL)
    return [[re.sub(r"<[^>]*>", "", cell).strip() for cell in re.findall(r"<td.*?</td>", row)] for row in rows]


def test_names_and_sizes_are_listed() -> None:
    names = (name("cone", 1500, counts((60, 1400), (64, 100))), name("ridge", 500, taxels=counts((40, 500))))
    page = page_of(file("a.npz"), names=names)
    # The middle of the sixtieth step of a twentieth of a decade from 10 µm on.
    assert cells(page, "Names and sizes") == [
        ["cone", "1\u202f500", "2", "50\u202f%", "11\u202fmm", "11\u202fmm to 17\u202fmm", ""],
        ["ridge", "500", "2", "50\u202f%", "11\u202ftaxels", "11\u202ftaxels", ""],
    ]
    assert "2\u202f000 contacts" in page
    assert "The spacing of taxels is not known of every recording" in page
    assert '--p: 0.7500"' in page


def test_the_worst_recordings_come_first_and_days_are_summed() -> None:
    files = [
        file("good.npz", "2026-11-21"),
        file("gaps.npz", "2026-11-21", n_lacking=500, says=("about 500 frames lacking",)),
        file("dead.npz", "2026-11-22", n_broken=64),
    ]
    page = page_of(*files, names=(name("cone", 30),))
    assert [row[0] for row in cells(page, "Health by file")] == ["dead.npz", "gaps.npz", "good.npz"]
    assert cells(page, "Health by file")[1][1:] == [
        "1\u202f000", "10\u202fs", "10", "10\u202f%", "", "500", "About 500 frames lacking."
    ]  # fmt: skip
    assert cells(page, "Health by day") == [
        ["2026-11-21", "2", "2\u202f000", "20\u202fs", "20", "10\u202f%", "", "500"],
        ["2026-11-22", "1", "1\u202f000", "10\u202fs", "10", "10\u202f%", "64 of 64", ""],
    ]
    assert "2, 2026-11-21 to 2026-11-22" in page
    assert "10\u202f% of the contacts have a name below 90\u202f%" in page
    assert 'aria-label="Health by day"' not in page_of(file("a.npz"))


def test_what_failed_is_told_before_all_else() -> None:
    failed = [file(f"{k}.npz", failure=f"{k}.npz: is bad") for k in range(20)]
    page = page_of(file("a.npz"), *failed)
    assert page.count("Not in the table: ") == 12
    assert "8 more recordings are not in the table" in page
    assert [row[0] for row in cells(page, "Health by file")] == ["a.npz"]


def test_doubtful_contacts_are_told_with_the_command_that_shows_them() -> None:
    one = Doubtful("my hand.npz", 7, 1, 0.5, "pad", "cone", 0.25, ("cone", "hip", "ridge"), (0.012, 0.006), True)
    page = page_of(file("my hand.npz"), names=(name("cone", 1),), doubtful=(one,))
    assert cells(page, "Doubtful contacts") == [
        ["cone", "25\u202f%", "hip, ridge", "12\u202fmm × 6\u202fmm", "my hand.npz", "7", "0.50\u202fs", "1"]
    ]
    assert "see &#39;my hand.npz&#39; at 7" in page


def test_names_of_files_can_do_nothing(tmp_path: Path) -> None:
    odd = '<script>alert("1")</script>.npz'
    one = Doubtful(odd, 7, 1, None, odd, odd, 0.25, (odd,), (12.0, 12.0), False)
    write_corpus_report(tmp_path / "page.html", Summary((name(odd, 3),), (one,), (file(odd),)), title=odd)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert not re.search(r"(src|href)=\"?(http|//)", page)


@pytest.mark.parametrize("n", [0, 1, 500])
def test_as_many_as_can_be_read_are_listed(n: int) -> None:
    page = page_of(*(file(f"{k}.npz") for k in range(n)))
    assert len(cells(page, "Health by file")) == min(n, 400)
    assert ("100 more recordings are not listed" in page) == (n == 500)


def test_bars_are_as_high_as_their_counts() -> None:
    drawn = str(size_bars(counts((30, 10), (31, 5), (90, 1)), label="sizes"))
    heights = [float(high) for high in re.findall(r"v-([\d.]+)h", drawn)]
    assert heights == [26.0, 13.0, 2.6]
    assert 'aria-label="sizes"' in drawn
    assert size_bars(NOTHING, label="none") == ""


def test_the_command_writes_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(recording(1), tmp_path / "a.npz")
    monkeypatch.chdir(tmp_path)
    words = ("touch", "a.npz", "-o", "names.parquet", "--workers", "1", "--report", "page.html")
    monkeypatch.setattr(sys, "argv", ["varishold", *words])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 0
    n = int(re.search(r"names.parquet: (\d+) contacts", capsys.readouterr().out)[1])  # type: ignore[index]
    assert f"<h2>{n} contacts</h2>" in (tmp_path / "page.html").read_text(encoding="utf-8")
