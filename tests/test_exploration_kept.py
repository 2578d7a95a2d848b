"""What was felt is kept line by line, and what is damaged of it is felt again."""

from __future__ import annotations

from errno import ENOSPC
from io import FileIO
from pathlib import Path

import pytest

from varishold.errors import InputError
from varishold.exploration import kept
from varishold.exploration.kept import keeper, kept_examples
from varishold.perceive import Evidence


@pytest.mark.parametrize(
    "damage",
    [b"\xff\xfe\x00", b"\x80\xff\n", b"[" * 100_000 + b"\n", b"null\n{}\n[1]\n", b'{"seed": 1e999, "touches": []}\n'],
)
def test_what_is_damaged_of_what_was_felt_is_felt_again(tmp_path: Path, damage: bytes) -> None:
    path, felt = tmp_path / "felt.jsonl", [Evidence("grasp", {"a": 1.0}), Evidence("tip", {}, failed=True)]
    with keeper(path, {3: felt}) as say:
        say(4, felt)
    whole = path.read_bytes()
    path.write_bytes(damage + b"\n" + whole)
    assert kept_examples(path) == {3: felt, 4: felt}
    path.write_bytes(whole[:-9])
    assert kept_examples(path) == {3: felt}


def test_a_file_where_what_is_felt_would_be_kept_is_told(tmp_path: Path) -> None:
    (tmp_path / "mine.npz.felt").touch()
    with (
        pytest.raises(InputError, match=r"mine\.npz\.felt: cannot be made a folder: it is a file; move it away"),
        keeper(tmp_path / "mine.npz.felt" / "a.jsonl", {}),
    ):
        pass


def test_a_full_disk_is_told_with_the_file_that_it_keeps_from_growing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Full(FileIO):
        def write(self, _: object) -> int:
            raise OSError(ENOSPC, "No space left on device")

    path = tmp_path / "felt.jsonl"
    monkeypatch.setattr(kept, "open", lambda name, mode, buffering: Full(name, mode), raising=False)
    with pytest.raises(InputError, match=r"felt\.jsonl: cannot write here: no space left"), keeper(path, {}) as say:
        say(3, [])
    assert kept_examples(path) == {}
