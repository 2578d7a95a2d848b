"""Dates in a time column: the same instants however they are written, and what is no date told with its line."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import FormatError
from varishold.recording import Recording, read
from varishold.recording.formats.csv_dates import date_at, date_seconds

BEGIN = datetime(2026, 11, 29, 10, 3, 4, 500000, UTC)
TIMES = [BEGIN + timedelta(milliseconds=20 * k) for k in range(5)]
SECONDS = [time.timestamp() for time in TIMES]
FRAMES = np.random.default_rng(0).integers(0, 9, (5, 2, 3))

ZONES = st.one_of(
    st.none(),
    st.integers(-14 * 60, 14 * 60).map(lambda minutes: timezone(timedelta(minutes=minutes))),
)


@given(
    when=st.datetimes(datetime(1900, 1, 2), datetime(2200, 1, 1)),
    zone=ZONES,
    between=st.sampled_from("T "),
    quote=st.sampled_from(["", '"']),
    point=st.sampled_from(".,"),
)
def test_a_date_is_its_instant_and_one_without_a_zone_is_in_utc(
    when: datetime, zone: timezone | None, between: str, quote: str, point: str
) -> None:
    instant = when.replace(tzinfo=zone or UTC)
    text = when.replace(tzinfo=zone).isoformat(between).replace(".", point)
    assert date_seconds(quote + text + quote) == pytest.approx(instant.timestamp(), rel=0, abs=1e-5)
    separated = "," if quote or point == "." else ";"
    for line, cell in ((f"{quote}{text}{quote}{separated}1{separated}2", 0), (f"7; {quote}{text}{quote};1", 1)):
        at = date_at(line, cell)
        assert at is not None
        assert line[at[0] : at[2]] == quote + text + quote
        assert float(at[1]) == date_seconds(text)
        assert "." not in at[1]


@pytest.mark.parametrize(
    "cell",
    ["", "5", "2026-11-29", "10:03:04", "2026-11-29T10:03", "2026-13-01T10:03:04", "2026-11-29T10:03:04 pm", "x"],
)
def test_what_is_no_date_and_time_is_none(cell: str) -> None:
    assert date_seconds(cell) is None
    assert date_at(f"{cell},1", 0) is None


def lines(path: Path, stamps: list[str], *, mark: str, header: str, decimal: str = ".") -> Path:
    rows = [
        mark.join([stamp, *(f"{value}{decimal}5" for value in frame.ravel())])
        for stamp, frame in zip(stamps, FRAMES, strict=True)
    ]
    path.write_text("\n".join(([header.replace(",", mark)] if header else []) + rows) + "\n")
    return path


@pytest.mark.parametrize(
    ("mark", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", ".")]
)
@pytest.mark.parametrize(
    "header", ["", "time,a,b,c,d,e,f", "timestamp_ns,a,b,c,d,e,f", ",a,b,c,d,e,f", "when,a,b,c,d,e,f"]
)
@pytest.mark.parametrize("zone", ["", "Z", "+00:00"])
def test_dates_are_times_whatever_separates_and_whatever_they_are_called(
    tmp_path: Path, mark: str, decimal: str, header: str, zone: str
) -> None:
    stamps = [time.strftime("%Y-%m-%dT%H:%M:%S.%f") + zone for time in TIMES]
    if mark == " " and header.startswith(","):
        header = ""
    recording = read(lines(tmp_path / "a.csv", stamps, mark=mark, header=header, decimal=decimal), shape=(2, 3))
    np.testing.assert_allclose(recording.time_s, SECONDS, rtol=0, atol=1e-6)  # type: ignore[arg-type]
    np.testing.assert_array_equal(recording.pads["pad"].frames, FRAMES + 0.5)
    assert recording.notes == ()


def logged(time: datetime) -> str:
    """As Python's module logging writes a time."""
    return f"{time:%Y-%m-%d %H:%M:%S},{time.microsecond // 1000:03d}"


@pytest.mark.parametrize("mark", [";", "\t", " "])
@pytest.mark.parametrize("header", ["", "time,a,b,c,d,e,f"])
def test_a_date_may_have_a_decimal_comma_where_commas_separate_nothing(tmp_path: Path, mark: str, header: str) -> None:
    stamps = [logged(time) for time in TIMES]
    for decimal in ".,"[: 1 + (mark != " ")]:
        recording = read(lines(tmp_path / "a.csv", stamps, mark=mark, header=header, decimal=decimal), shape=(2, 3))
        np.testing.assert_allclose(recording.time_s, SECONDS, rtol=0, atol=1e-6)  # type: ignore[arg-type]
        np.testing.assert_array_equal(recording.pads["pad"].frames, FRAMES + 0.5)
    quoted = lines(tmp_path / "b.csv", [f'"{stamp}"' for stamp in stamps], mark=",", header=header)
    np.testing.assert_allclose(read(quoted, shape=(2, 3)).time_s, SECONDS, rtol=0, atol=1e-6)  # type: ignore[arg-type]


def test_a_comma_that_may_separate_or_not_is_asked_about(tmp_path: Path) -> None:
    path = lines(tmp_path / "a.csv", [logged(time) for time in TIMES], mark=",", header="")
    with pytest.raises(FormatError, match="for this shape; got 8; if the first of them are fractions of the dates"):
        read(path, shape=(2, 3))
    # A taxel behind a date without a fraction.
    path.write_text("2026-11-29 10:03:04,5\n2026-11-29 10:03:05,6\n")
    assert read(path, shape=(1, 1)).pads["pad"].frames.ravel().tolist() == [5, 6]


def test_dates_may_stand_behind_a_number_and_all_down_a_frame(tmp_path: Path) -> None:
    stamps = [f"{time:%Y-%m-%d %H:%M:%S.%f}" for time in TIMES]
    rows = [
        [str(k), stamp, *map(str, frame.ravel())] for k, (stamp, frame) in enumerate(zip(stamps, FRAMES, strict=True))
    ]
    (tmp_path / "a.csv").write_text("\n".join(",".join(row) for row in [["", "time", *"abcdef"], *rows]))
    blocks = [
        "\n".join(",".join([stamp, *map(str, row)]) for row in frame)
        for stamp, frame in zip(stamps, FRAMES, strict=True)
    ]
    (tmp_path / "b.csv").write_text("\n\n".join(blocks) + "\n")
    for recording in (read(tmp_path / "a.csv", shape=(2, 3)), read(tmp_path / "b.csv")):
        np.testing.assert_allclose(recording.time_s, SECONDS, rtol=0, atol=1e-6)  # type: ignore[arg-type]
        np.testing.assert_array_equal(recording.pads["pad"].frames, FRAMES)


def presses(path: Path, stamps: list[str]) -> Path:
    names = [f"pad.{r}.{c}" for r in range(2) for c in range(3)]
    rows = [[stamp, "cup", *map(str, frame.ravel())] for stamp, frame in zip(stamps, FRAMES, strict=True)]
    path.write_text("\n".join(",".join(row) for row in [["time", "label", *names], *rows]) + "\n")
    return path


def test_dates_are_times_of_presses(tmp_path: Path) -> None:
    recording: Recording = read(presses(tmp_path / "a.csv", [time.isoformat() for time in TIMES]))
    np.testing.assert_allclose(recording.time_s, SECONDS, rtol=0, atol=1e-6)  # type: ignore[arg-type]
    assert list(recording.press_columns["label"]) == ["cup"] * 5
    quoted = read(presses(tmp_path / "b.csv", [f'"{logged(time)}"' for time in TIMES]))
    np.testing.assert_allclose(quoted.time_s, SECONDS, rtol=0, atol=1e-6)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ("5", "line 4, column {} must be a date, as in the lines before it, got '5'"),
        ("soon", "line 4, column {} must be "),
        ("2026-02-30T00:00:00", "line 4, column {} must be "),
    ],
)
def test_a_time_that_is_none_beside_dates_is_told_with_its_line(tmp_path: Path, wrong: str, says: str) -> None:
    stamps = [time.isoformat() for time in TIMES]
    stamps[2] = wrong
    with pytest.raises(FormatError, match=says.format(1)):
        read(lines(tmp_path / "a.csv", stamps, mark=",", header="time,a,b,c,d,e,f"), shape=(2, 3))
    with pytest.raises(FormatError, match=says.format("'time'")):
        read(presses(tmp_path / "b.csv", stamps))


def test_a_date_is_no_taxel(tmp_path: Path) -> None:
    path = lines(tmp_path / "a.csv", [time.isoformat() for time in TIMES], mark=",", header="")
    with pytest.raises(FormatError, match="column 1 is dates, and a line must hold 7 numbers of taxels beside it"):
        read(path, shape=(1, 7))
    (tmp_path / "b.csv").write_text(f"time,timestamp,a\n0,{TIMES[0].isoformat()},1\n\n1,{TIMES[1].isoformat()},2\n")
    with pytest.raises(FormatError, match="column 2 is dates, and stands where taxels begin; leave it out, or put it"):
        read(tmp_path / "b.csv")


def test_a_last_line_that_was_cut_off_in_its_date_is_left_out(tmp_path: Path) -> None:
    path = lines(tmp_path / "a.csv", [time.isoformat() for time in TIMES], mark=",", header="")
    path.write_text(path.read_text() + "2026-11-29T10:0")
    recording = read(path, shape=(2, 3))
    np.testing.assert_allclose(recording.time_s, SECONDS, rtol=0, atol=1e-6)  # type: ignore[arg-type]
    assert recording.notes == ("line 6 is cut off in the middle, and left out: it has 1 of 7 numbers",)
