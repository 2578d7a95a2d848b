"""The house: statements by room, and the way of a frame from the command to its name.

Statements are counted in the syntax tree, docstrings apart; tables of data are no Python files. The way is drawn from
the imports between the modules that are entered when a recording is recognized. Ends with status 1 where a law of the
house does not hold.

    python -m benchmarks.house
"""

from __future__ import annotations

import ast
import contextlib
import io
import sys
import tomllib
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import FrameType

import varishold
from benchmarks._figures import figure

ROOT = Path(varishold.__file__).parent
PROJECT = ROOT.parent.parent
#: Statements of the house before its rooms were set apart.
BEFORE = 16_394
#: What has been built since, and is no part of that count.
NEW = (
    "calibration",
    "cli/browser.py",
    "cli/convert.py",
    "cli/corpus.py",
    "cli/decision_file.py",
    "cli/demo.py",
    "cli/distortions.py",
    "cli/doctor.py",
    "cli/evaluate.py",
    "cli/felt_surface.py",
    "cli/hand_file.py",
    "cli/info.py",
    "cli/learn.py",
    "cli/made.py",
    "cli/objects.py",
    "cli/odd_clock.py",
    "cli/options.py",
    "cli/live",
    "cli/record",
    "cli/replay.py",
    "cli/silence.py",
    "cli/sources",
    "cli/taxels.py",
    "cli/thing.py",
    "corpus",
    "evaluation",
    "exploration/hand_library.py",
    "exploration/kept.py",
    "exploration/mesh_object.py",
    "exploration/object_examples.py",
    "exploration/senses.py",
    "exploration/shape.py",
    "exploration/surface_contacts.py",
    "files/crew.py",
    "files/growing.py",
    "frame/common_drift.py",
    "frame/following_baseline.py",
    "frame/frame_clock.py",
    "frame/health_report.py",
    "frame/level.py",
    "frame/order_statistics.py",
    "frame/patches.py",
    "frame/polarity.py",
    "frame/press_return.py",
    "frame/pressed.py",
    "frame/quiet_window.py",
    "frame/readings.py",
    "frame/repair.py",
    "frame/running_",
    "frame/zero.py",
    "grasp/answer.py",
    "grasp/held_out.py",
    "grasp/unknown.py",
    "hand/hand.py",
    "hand/mjcf",
    "hand/palm_place.py",
    "hand/scene.py",
    "learning",
    "levelset/batch.py",
    "levelset/contact_state.py",
    "levelset/table.py",
    "live",
    "recording/conversion.py",
    "perceive/contour_mesh.py",
    "perceive/distance_bound.py",
    "perceive/distance_process.py",
    "perceive/implicit_surface.py",
    "perceive/name_evidence.py",
    "perceive/plain_body.py",
    "perceive/poor_pads.py",
    "perceive/prior_file.py",
    "perceive/seen.py",
    "perceive/surface_points.py",
    "recording/formats/blosc",
    "recording/formats/grouped_arrays",
    "recording/formats/guessing.py",
    "recording/formats/hdf5",
    "recording/formats/icub_grasp",
    "recording/formats/lerobot",
    "recording/formats/mat",
    "recording/formats/mcap",
    "recording/formats/named_arrays",
    "recording/formats/packings",
    "recording/formats/parquet",
    "recording/formats/picture",
    "recording/formats/press_rows",
    "recording/formats/rosbag",
    "recording/formats/taxel_columns",
    "recording/formats/tiff_",
    "recording/formats/topics_said",
    "recording/formats/zarr",
    "recording/mcap",
    "recording/inspection.py",
    "recording/messages",
    "recording/press_table.py",
    "recording/stored.py",
    "report/confusion_map.py",
    "report/corpus_report.py",
    "report/evaluation_report.py",
    "report/evaluation_words.py",
    "report/scene_data.py",
    "report/senses.py",
    "report/share_chart.py",
    "report/size_bars.py",
    "report/surface_drawing.py",
    "report/surface_words.py",
    "sensor",
    "solids/body_height.py",
    "solids/laid.py",
    "solids/mesh_",
    "touch/contact_network.py",
    "touch/course/borne.py",
    "touch/course/held.py",
    "touch/course/measures.py",
    "touch/course/presses.py",
    "touch/course/unlike.py",
    "touch/cut.py",
    "touch/pad_frames.py",
    "touch/scale.py",
    "touch/pooling.py",
    "touch/sensing.py",
    "touch/state.py",
    "touch/tracking",
    "touch/writers",
    "trust/conformal.py",
    "trust/folds.py",
    "trust/probability.py",
    "trust/ranges.py",
)
KERNEL = "the compiled kernel"
MOST_MODULES, MOST_LINES = 7, 400


def statements(path: Path) -> int:
    """Return the number of statements of a file, docstrings apart."""

    def is_text(node: ast.stmt) -> bool:
        return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)

    tree = ast.parse(path.read_text(encoding="utf-8"))
    return sum(isinstance(node, ast.stmt) and not is_text(node) for node in ast.walk(tree))


def room_of(path: Path) -> str:
    """Return the room that a file of the package stands in."""
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def by_room() -> tuple[Counter[str], int]:
    """Return the statements of each room, and those of what is new in the house."""
    rooms: Counter[str] = Counter()
    new = 0
    for path in ROOT.rglob("*.py"):
        count = statements(path)
        rooms[room_of(path)] += count
        new += count * path.relative_to(ROOT).as_posix().startswith(NEW)
    return rooms, new


def order_of_rooms() -> list[str]:
    """Return the rooms from the first that a signal meets to the last, as the layers of the project say."""
    contracts = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (layers,) = (c["layers"] for c in contracts["contracts"] if c["type"] == "layers")
    return [layer.strip("()").removeprefix("varishold.") for layer in reversed(layers)]


class Way:
    """The modules of ours that a call enters, in order, and who called whom."""

    def __init__(self) -> None:
        self.entered: dict[Path, set[str]] = {}
        self.steps: set[tuple[Path, Path]] = set()

    @property
    def modules(self) -> list[Path]:
        """The modules in which Python runs."""
        return [path for path in self.entered if room_of(path) != "kernel"]

    @property
    def compiled(self) -> list[Path]:
        """The modules by which the kernel is called: together they are the kernel."""
        return [path for path in self.entered if room_of(path) == "kernel"]

    def _ours(self, frame: FrameType | None) -> Path | None:
        while frame is not None:
            path = Path(frame.f_code.co_filename)
            if path.is_relative_to(ROOT):
                return path
            frame = frame.f_back
        return None

    def _see(self, frame: FrameType, event: str, argument: object) -> None:
        if event != "call" or not Path(frame.f_code.co_filename).is_relative_to(ROOT):
            return
        path, caller = Path(frame.f_code.co_filename), self._ours(frame.f_back)
        self.entered.setdefault(path, set()).add(frame.f_code.co_name)
        if caller is not None and caller != path:
            self.steps.add((caller, path))

    def take(self, call: Callable[[], object]) -> Way:
        """Run a call, seen."""
        sys.setprofile(self._see)
        try:
            call()
        finally:
            sys.setprofile(None)
        return self


def imports_of(path: Path) -> Iterator[str]:
    """Yield the modules of ours that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("varishold"):
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


def name_of(path: Path) -> str:
    """Return a file's module name without the package's."""
    return path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".").removesuffix(".__init__")


def through_imports(modules: Iterable[Path], start: str, end: str) -> list[str]:
    """Return the shortest way from one module to another along imports among `modules`; empty if there is none."""
    known = {name_of(path): path for path in modules}
    came: dict[str, str] = {start: ""}
    queue = deque([start])
    while queue and end not in came:
        here = queue.popleft()
        for module in imports_of(known[here]):
            there = module.removeprefix("varishold.")
            if there in known and there not in came:
                came[there] = here
                queue.append(there)
    way = [end] if end in came else []
    while way and came[way[0]]:
        way.insert(0, came[way[0]])
    return way


def recognition() -> Way:
    """Return what `find_contacts` and `recognize` enter together once all is compiled."""
    import numpy as np

    from varishold.touch import find_contacts, recognize

    y, x = np.mgrid[-12:13, -12:13]
    frame = np.maximum(9.0 - np.hypot(x, y), 0.0)
    recognize(find_contacts(frame)[0])
    return Way().take(lambda: recognize(find_contacts(frame)[0]))


def command() -> Way:
    """Return what ``varishold touch FILE`` enters."""
    from varishold.cli.app import app

    def run() -> None:
        with contextlib.redirect_stdout(io.StringIO()):
            app(["touch", str(PROJECT / "examples" / "surfaces.npz")], standalone_mode=False)

    return Way().take(run)


def broken_laws() -> list[str]:
    """Return the laws of the house that do not hold, in words."""
    said = []
    rooms, new = by_room()
    if rooms.total() - new >= BEFORE:
        said.append(f"{rooms.total() - new} statements are not fewer than {BEFORE}")
    order = order_of_rooms()
    way = recognition()
    names = [name_of(path) for path in way.modules] + [KERNEL]
    if len(names) > MOST_MODULES:
        said.append(f"{len(names)} modules are entered, at most {MOST_MODULES} may be: {', '.join(names)}")
    for path in [*way.entered, *(ROOT / "levelset").glob("*.py")]:
        lines = len(path.read_text(encoding="utf-8").splitlines())
        if lines > MOST_LINES:
            said.append(f"{name_of(path)} has {lines} lines, at most {MOST_LINES} may be")
    for caller, callee in sorted(way.steps):
        one, other = room_of(caller), room_of(callee)
        if one != other and order.index(other) > order.index(one):
            said.append(f"{name_of(caller)} climbs up to {name_of(callee)}")
    return said


def main() -> None:
    """Print the house, and end with status 1 where a law does not hold."""
    rooms, new = by_room()
    old = figure("statements of src without what is new", rooms.total() - new, bar=f"< {BEFORE}")
    print(f"statements of src: {figure('statements of src', rooms.total())}, {old} without what is new")
    for room, count in rooms.most_common():
        print(f"  {room:<14}{figure(f'statements of {room}', count, '>6')}")
    print("\nentered by find_contacts and recognize together:")
    way = recognition()
    for path in way.modules:
        lines = figure(f"lines of {name_of(path)}", len(path.read_text(encoding="utf-8").splitlines()), ">5", "lines")
        print(f"  {name_of(path):<28}{lines}")
    print(f"  {KERNEL} ({', '.join(name_of(path) for path in way.compiled)})")
    entered = list(command().entered)
    n_entered = figure("modules that varishold touch enters", len(entered))
    print(f"\nvarishold touch FILE enters {n_entered} modules; from the command to the kernel:")
    kernel = ROOT / "levelset" / "kernel.py"
    for start, end in (("cli.touch", "touch.recordings"), ("touch.recordings", "levelset.kernel")):
        print("  " + " -> ".join(through_imports([*entered, kernel], start, end)))
    broken = broken_laws()
    for law in broken:
        print(f"broken: {law}")
    if broken:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
