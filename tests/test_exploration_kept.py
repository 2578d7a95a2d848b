"""What was felt is kept line by line, and what is damaged of it is felt again."""

from __future__ import annotations

from pathlib import Path

import pytest

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
