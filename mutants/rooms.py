"""Which files belong to a room, and which tests are its own."""

from __future__ import annotations

from pathlib import Path

__all__ = ["PACKAGE", "rooms", "sources", "tests"]

PACKAGE = Path("src/varishold")

# A room's own tests are tests/test_ROOM.py, tests/test_ROOM_*.py and the examples in its docstrings. Beside them:
_ALSO = {
    # every test that runs a command
    "cli": (
        "test_cli*.py",
        "test_calibration.py",
        "test_evaluation_commands.py",
        "test_hand_commands.py",
        "test_evaluation_yardstick_score.py",
        "test_learning_commands.py",
        "test_perceive_command.py",
        "test_paper_tables.py",
        "test_skin_draws.py",
        "test_grasp_model.py",
        "test_touch_export.py",
        "test_touch_sensor.py",
        "test_corpus_measure.py",
        "test_corpus_run.py",
        "test_live_command.py",
        "test_live_record_command.py",
        "test_live_sources_command.py",
        "test_recording_conversion.py",
        "test_recording_inspection.py",
    ),
    "paper": ("test_hand_table5.py",),
    "report": ("test_skin_figures.py",),
}


def rooms(root: Path) -> list[str]:
    """Return the names of all rooms of the tree."""
    return sorted(p.parent.name for p in (root / PACKAGE).glob("*/__init__.py"))


def sources(root: Path, room: str) -> list[Path]:
    """Return the room's source files, relative to the root."""
    return sorted(p.relative_to(root) for p in (root / PACKAGE / room).rglob("*.py"))


def tests(root: Path, room: str) -> list[Path]:
    """Return the files whose tests are the room's own, relative to the root."""
    patterns = (f"test_{room}.py", f"test_{room}_*.py", *_ALSO.get(room, ()))
    found = {path for pattern in patterns for path in (root / "tests").glob(pattern)}
    examples = {root / path for path in sources(root, room) if ">>> " in (root / path).read_text("utf-8")}
    return sorted(path.relative_to(root) for path in found | examples)
