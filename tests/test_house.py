"""The laws of the house: few modules on a frame's way, short files, no climb back up."""

from __future__ import annotations

from benchmarks import house


def test_the_way_of_a_frame_is_short_and_goes_down() -> None:
    assert [law for law in house.broken_laws() if "statements" not in law] == []


def test_statements_are_counted_without_docstrings(tmp_path) -> None:
    path = tmp_path / "few.py"
    path.write_text('"""Text."""\n\nimport os\n\n\ndef f():\n    """Text."""\n    return os\n')
    assert house.statements(path) == 3


def test_the_command_reaches_the_kernel_through_imports() -> None:
    modules = [*house.ROOT.rglob("*.py")]
    assert house.through_imports(modules, "cli.touch", "levelset.kernel")[-1] == "levelset.kernel"
    assert house.through_imports(modules, "levelset.kernel", "cli.touch") == []
