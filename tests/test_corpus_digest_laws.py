"""Digests against plain ones: all of what is read is in them, and no two things have the same."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, make_dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varishold
from varishold.corpus import AskMeasure, AskTouch, content
from varishold.corpus.content import content_digest, digest_of, files_of, program_digest
from varishold.corpus.opened import Reading
from varishold.errors import InputError


def plain(*pieces: bytes) -> str:
    """Digest pieces, each after its length."""
    return hashlib.blake2b(b"".join(len(p).to_bytes(8, "little") + p for p in pieces), digest_size=16).hexdigest()


def test_a_digest_of_values_is_the_plain_one() -> None:
    assert digest_of("a", 1) == plain(b"2 values", b"str 'a'", b"int 1")
    assert digest_of(b"raw") == plain(b"1 values", b"raw")
    table = np.arange(6, dtype="<i4").reshape(2, 3)
    assert digest_of(table) == plain(b"1 values", b"<i4(2, 3)", table.tobytes())
    # Two pairs of a name and a value.
    assert digest_of({"a": None}) == plain(b"1 values", b"1 values", b"2 values", b"str 'a'", b"NoneType None")


@dataclass
class One:
    a: Any = 1
    b: Any = 2


def test_no_two_values_have_the_same_digest() -> None:
    ones = np.ones((2, 3))
    values: list[Any] = [
        (), (1,), (1, 2), (2, 1), ((1,), 2), (1, (2,)), ((1, 2),), "1", ("1", 2), ("12",), 1.0, True, None, "None",
        b"1", b"12", (b"1", b"2"), ones, ones.T, ones.astype(np.float32), ones + 1, [ones, ones], {"a": 1}, {"b": 1},
        {"a": 2}, {"a": 1, "b": 2}, One(), One(a=2), One(1, 1), make_dataclass("Two", [("a", Any, 1), ("b", Any, 2)])(),
        make_dataclass("One", [("a", Any, 1), ("c", Any, 2)])(), Reading(), Reading("a"), Reading(None, (1, 2)),
        Reading(None, (2, 1)), Reading(None, None, 1.0), AskTouch(), AskTouch("press"), AskTouch(levels=16),
        AskTouch(exact=True), AskMeasure(), AskMeasure(16), AskMeasure(32, 0.0), AskMeasure(32, 1.0), One,
    ]  # fmt: skip
    for one, other in combinations(range(len(values)), 2):
        assert digest_of(values[one]) != digest_of(values[other]), (values[one], values[other])
    # How an array lies in memory is no matter.
    wide = np.arange(12.0).reshape(3, 4)
    assert digest_of(np.asfortranarray(wide)) == digest_of(wide)
    assert digest_of(np.repeat(wide, 2, axis=1)[:, ::2]) == digest_of(wide)


@settings(max_examples=40)
@given(st.binary(max_size=200), st.integers(1, 64))
def test_a_file_s_digest_is_of_its_ending_and_of_all_its_bytes(
    tmp_path_factory: pytest.TempPathFactory, held: bytes, at_a_time: int
) -> None:
    folder = tmp_path_factory.mktemp("d")
    (folder / "a.NPY").write_bytes(held)
    expected = hashlib.blake2b(b".npy" + held, digest_size=16).hexdigest()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(content, "_BLOCK", at_a_time)
        assert content_digest(str(folder / "a.NPY")) == expected
    (folder / "b.npy").write_bytes(held)
    (folder / "b.csv").write_bytes(held)
    assert content_digest(str(folder / "b.npy")) == expected != content_digest(str(folder / "b.csv"))


def test_a_folder_s_digest_is_of_the_names_and_bytes_of_its_files(tmp_path: Path) -> None:
    folder = tmp_path / "rec.zarr"
    (folder / "in" / "deep").mkdir(parents=True)
    (folder / "in" / "deep" / "z").write_bytes(b"1")
    (folder / "b").write_bytes(b"2")
    (folder / "a").write_bytes(b"")
    assert files_of(folder) == [folder / "a", folder / "b", folder / "in" / "deep" / "z"]
    assert files_of(folder / "b") == [folder / "b"]
    digest = hashlib.blake2b(b".zarr", digest_size=16)
    for name, held in (("a", b""), ("b", b"2"), (str(Path("in", "deep", "z")), b"1")):
        digest.update(digest_of(name).encode() + held)
    assert content_digest(str(folder)) == digest.hexdigest()
    before = content_digest(str(folder))
    (folder / "b").rename(folder / "c")
    assert content_digest(str(folder)) != before
    with pytest.raises(InputError, match="none"):
        content_digest(str(tmp_path / "none"))


def test_the_program_is_all_its_code_and_all_its_parameters() -> None:
    home = Path(varishold.__file__).parent
    endings = (".py", ".so", ".dll", ".dylib", ".npz", ".toml")
    digest = hashlib.blake2b(digest_size=16)
    named = {"".join(f"/{part}" for part in p.relative_to(home).parts): p for p in home.rglob("*") if p.is_file()}
    for name in sorted(name for name in named if name.endswith(endings)):
        digest.update(digest_of(name, named[name].read_bytes()).encode())
    assert program_digest() == digest.hexdigest()
    assert program_digest() is program_digest()
