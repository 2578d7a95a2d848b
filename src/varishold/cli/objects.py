"""``varishold objects``: what a library knows, and things of a user's own for it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.hand_file import FeelingHandName, hand_named, require_library_of
from varishold.cli.printing import echo, print_json, printable, tell

if TYPE_CHECKING:
    from varishold.perceive import Library
    from varishold.solids import MeshSolid

_KNOWN = Annotated[
    Path | None,
    Option("A library of objects (NPZ); default: the shipped one.", metavar="FILE"),
    Reads(),
]

# Of fewer examples more than one in twenty touches of the thing itself is stranger than all.
_FEW_EXAMPLES = 19


def register(app: Commands) -> None:
    """Add the group to the program."""
    group = app.subgroup("objects", "Objects that the hand knows, and your own (extra 'meshes').")
    group.command("add")(add)
    group.command("feel")(feel)
    group.command("list")(list_objects)
    group.command("show")(show)
    group.command("taxels")(taxels)


def add(
    meshes: Annotated[
        list[Path],
        Argument("Meshes (.stl, .obj, .ply): closed, z up, as it stands on a table.", metavar="MESH..."),
        Reads(),
    ],
    library: Annotated[
        Path,
        Option("The library to grow (NPZ); where there is none it begins as the shipped one.", metavar="FILE"),
        Writes("library"),
    ],
    name: Annotated[
        list[str] | None,
        Option("What it is called; once a mesh where there are several. Default: the file's name."),
    ] = None,
    size_m: Annotated[
        float | None,
        Option(
            "The larger of its level extents (x, y) in metres, to which it is scaled. "
            "Default: the file's numbers are metres."
        ),
    ] = None,
    examples: Annotated[int | None, Option("How many times each is felt. Default: 50.", min=1, max=10_000)] = None,
    seed: Annotated[int, Option("The same seed gives the same library.", min=0)] = 0,
    workers: Annotated[int | None, Option("Processes to work with. Default: one a processor.", min=1, max=4096)] = None,
    hand: FeelingHandName = None,
    force: Annotated[bool, Option("Replace a file that is no library.")] = False,
    json: Annotated[bool, Option("Print one JSON object a thing.")] = False,
) -> None:
    """Let the simulated hand feel meshes, and add them to a library; a call that was stopped goes on when repeated."""
    from varishold.cli.progress import progress_bar
    from varishold.exploration import feel_examples, kept_beside
    from varishold.exploration.object_examples import USUAL_EXAMPLES, example_setting
    from varishold.files import only_writer
    from varishold.hand.model import require_mujoco
    from varishold.perceive import write_library
    from varishold.perceive.likeness import taken_for

    require_mujoco()
    setting = example_setting(hand_named(hand))
    with only_writer(library):
        grown = _library(library, force)
        require_library_of(setting.design, grown, where=str(library), given=hand or "")
        things = _things(meshes, name, size_m, grown)
        count = USUAL_EXAMPLES if examples is None else examples
        kept = {thing.called: kept_beside(library, thing, seed=seed, setting=setting) for thing in things}
        lines = []
        with progress_bar("examples", count * len(things)) as update:
            for thing in things:
                felt = feel_examples(
                    thing,
                    examples=count,
                    seed=seed,
                    setting=setting,
                    processes=workers,
                    keep=kept[thing.called],
                    progress=lambda: update(advance=1),
                )
                lines.append((thing, len(felt), taken_for(grown, felt)))
                grown = grown.with_object(thing.called, felt, size_m=thing.size_m)
        write_library(grown, library)
        _forget(list(kept.values()))
    for thing, n, alike in lines:
        notes = _notes(n, alike)
        told: dict[str, Any] = {
            "object": thing.called,
            "size_m": thing.size_m,
            "extents_m": list(thing.extents_m),
            "parts": len(thing.parts),
            "examples": n,
            "missed": count - n,
            "taken_for": alike,
            "remarks": [*thing.remarks, *notes],
            "library": str(library),
            "objects": len(grown.objects),
        }
        if json:
            print_json(told)
            continue
        parts = counted(len(thing.parts), "convex part")
        echo(
            f"{thing.called}: {_millimetres(thing.extents_m)}, {parts}, "
            f"felt {counted(n, 'time') if n == count else f'{n} of {count} times'}"
        )
        for note in notes:
            tell(f"note: {thing.called}: {note}")
    if not json:
        echo(f"{library}: {counted(len(grown.objects), 'object')}")


def _notes(n: int, alike: dict[str, int]) -> list[str]:
    """Return in words what a new object's examples are too few for, and what they are too like to."""
    notes = []
    if n < _FEW_EXAMPLES:
        notes.append(f"one in {n + 1} touches of it will be stranger than the {n} it was felt by, and refused")
    name, times = next(iter(alike.items()), ("", 0))
    if 2 * times > n:
        notes.append(f"before it was added {times} of {n} were taken for {name}: each may be taken for the other now")
    return notes


def feel(
    output: Annotated[Path, Option("The library to write (NPZ).", short="-o"), Writes("measurement", ending=".npz")],
    hand: FeelingHandName = None,
    examples: Annotated[int, Option("How many times each of the ten objects is felt.", min=10, max=10_000)] = 50,
    lumps: Annotated[
        int | None,
        Option(
            "How many shapes made by chance are felt, once each: of more, strangers are noticed oftener. Default: "
            "as many as --examples.",
            min=0,
            max=10_000,
        ),
    ] = None,
    seed: Annotated[int, Option("The same seed gives the same library.", min=0)] = 0,
    workers: Annotated[int | None, Option("Processes to work with. Default: one a processor.", min=1, max=4096)] = None,
    json: Annotated[bool, Option("Print one JSON object.")] = False,
) -> None:
    """Let a hand feel the ten objects, and shapes made by chance, for a library of its own.

    A call that was stopped goes on when repeated.
    """
    from varishold.cli.progress import progress_bar
    from varishold.exploration.hand_library import feel_library, library_kept_beside
    from varishold.exploration.object_examples import example_setting
    from varishold.files import only_writer
    from varishold.hand import OBJECTS
    from varishold.hand.model import require_mujoco
    from varishold.perceive import write_library

    require_mujoco()
    setting = example_setting(hand_named(hand))
    kept = library_kept_beside(output, setting, seed=seed)
    with only_writer(output):
        others = examples if lumps is None else lumps
        with progress_bar("examples", examples * len(OBJECTS) + others) as update:
            made = feel_library(
                setting,
                examples=examples,
                lumps=others,
                seed=seed,
                processes=workers,
                keep=kept,
                progress=lambda: update(advance=1),
            )
        write_library(made, output)
        _forget([kept])
    by = setting.design.identity.partition("@")[0]
    if json:
        rows = {row["object"]: row["examples"] for row in (_row(made, name) for name in made.objects)}
        print_json({"library": str(output), "hand": by, "objects": rows, "touches": list(made.touches), "seed": seed})
        return
    echo(f"{output}: {counted(len(made.objects), 'object')}, felt {counted(len(made), 'time')} by the hand {by}")
    echo(f"touches: {', '.join(made.touches)}")


def taxels(
    words: Annotated[
        str,
        Argument(
            "What the pads' taxels are like, as in noise=.03,crosstalk=.08,gain-spread=.15,dead=.03; also stuck "
            "and bits.",
            metavar="KIND=SHARE,...",
        ),
    ],
    output: Annotated[Path, Option("The library to write (NPZ).", short="-o"), Writes("taxel library", ending=".npz")],
    library: _KNOWN = None,
    seed: Annotated[int, Option("The same seed gives the same library.", min=0)] = 0,
    json: Annotated[bool, Option("Print one JSON object.")] = False,
) -> None:
    """Write a library that knows what the pads' taxels are like, so that known objects are not refused for them."""
    from dataclasses import asdict

    from varishold.cli.taxels import felt_by, taxels_of
    from varishold.errors import require
    from varishold.perceive.library_file import write_as

    of, felt = taxels_of(words), _read(library)
    require(
        felt.hand is None, f"{library}: was felt by another hand; what taxels do is known of the built-in one's pads"
    )
    known = felt_by(of, felt, seed=seed)
    write_as("taxel library", known, output)
    if json:
        told = {name.replace("_", "-"): value for name, value in asdict(of).items() if value}
        print_json({"library": str(output), "objects": len(known.objects), "taxels": told, "seed": seed})
        return
    echo(f"{output}: {counted(len(known.objects), 'object')}, felt by taxels of {words}")


def _library(path: Path, force: bool) -> Library:
    """Return the library to grow: that of the file, or the shipped one where there is none."""
    from varishold.errors import InputError
    from varishold.files import KINDS
    from varishold.perceive import read_library, shipped_library
    from varishold.perceive.library_file import _SHIPPED

    if path.exists() and path.samefile(_SHIPPED):
        raise InputError(f"{path}: is the shipped library, which is never written; name another file")
    begins = not path.exists() or path.stat().st_size == 0 or (force and not KINDS["library"].recognizes(path))
    return shipped_library() if begins else read_library(path)


def _things(meshes: list[Path], names: list[str] | None, size_m: float | None, library: Library) -> list[MeshSolid]:
    """Read all meshes; every name is checked before the first is taken apart."""
    from varishold.cli.thing import tell_remarks
    from varishold.errors import InputError
    from varishold.exploration import mesh_to_grip
    from varishold.exploration.mesh_object import check_name

    if names and len(names) != len(meshes):
        raise InputError(
            f"{counted(len(meshes), 'mesh needs', 'meshes need')} as many names, got {len(names)}", parameter="name"
        )
    called = [check_name(each) for each in names or [path.stem for path in meshes]]
    for k, each in enumerate(called):
        if each in library.objects:
            raise InputError(
                f"{meshes[k]}: the library knows an object called {each!r} already; give another name", parameter="name"
            )
        if each in called[:k]:
            raise InputError(f"{meshes[k]}: two meshes are called {each!r}; give a name to each", parameter="name")
    things = [mesh_to_grip(path, size_m=size_m, name=each) for path, each in zip(meshes, called, strict=True)]
    for path, thing in zip(meshes, things, strict=True):
        tell_remarks(path, thing)
    return things


def _forget(kept: list[Path]) -> None:
    """Remove what was kept in case of a stop; what another call keeps there stays, and is told."""
    from contextlib import suppress

    folder = kept[0].parent
    with suppress(OSError):
        for path in kept:
            path.unlink(missing_ok=True)
        if any(folder.iterdir()):
            tell(f"note: {folder} keeps what stopped calls with other options felt; remove it, or repeat them")
            return
        folder.rmdir()


def list_objects(
    library: _KNOWN = None,
    json: Annotated[bool, Option("Print one JSON object an object.")] = False,
) -> None:
    """List the objects that a library knows."""
    known = _read(library)
    rows = [_row(known, name) for name in known.objects]
    if json:
        for row in rows:
            print_json(row)
        return
    wide = max(len(printable(row["object"])) for row in rows)
    for row in rows:
        echo(f"{row['object']:<{wide}}  {row['examples']:>5} examples  {_sizes(row)}")


def show(
    name: Annotated[str, Argument("The object's name.", metavar="NAME")],
    library: _KNOWN = None,
    json: Annotated[bool, Option("Print one JSON object.")] = False,
) -> None:
    """Show what a library knows of an object: examples, sizes, and how well each touch tells strangers."""
    import numpy as np

    known = _read(library)
    k = known.index(name)
    own = known.owner == k
    touches = {}
    for touch, model in known.touches.items():
        power = float(model.power[k])
        touches[touch] = {
            "made": int(model.made[own].sum()),
            "failed": int(model.failed[own].sum()),
            "power": power if np.isfinite(power) else None,
            "cost": model.cost,
            "seconds": model.seconds,
        }
    row = _row(known, name)
    if json:
        print_json(row | {"touches": touches})
        return
    echo(f"{name}: {counted(row['examples'], 'example')}, {_sizes(row)}")
    wide = max(len(touch) for touch in touches)
    for touch, told in touches.items():
        alike = "" if told["power"] is None else f", tells {100 * told['power']:3.0f} % of what is most like it from it"
        echo(f"  {touch:<{wide}}  felt {told['made']:>4} times, failed {told['failed']:>3}{alike}")


def _read(path: Path | None) -> Library:
    from varishold.perceive import read_library, shipped_library

    return shipped_library() if path is None else read_library(path)


def _row(library: Library, name: str) -> dict[str, Any]:
    """What is said of an object in one line; sizes in metres, null where none is known."""
    import numpy as np

    own = library.owner == library.index(name)
    sizes = np.exp(library.log_size[own & np.isfinite(library.log_size)])
    span = None if not len(sizes) else [round(float(sizes.min()), 6), round(float(sizes.max()), 6)]
    return {"object": name, "examples": int(own.sum()), "sizes_m": span}


def _sizes(row: dict[str, Any]) -> str:
    if row["sizes_m"] is None:
        return "size unknown"
    low, high = (1e3 * size for size in row["sizes_m"])
    return f"{low:.0f} mm" if high - low < 0.5 else f"{low:.0f} to {high:.0f} mm"


def _millimetres(extents_m: tuple[float, float, float]) -> str:
    return " x ".join(f"{1e3 * each:.0f}" for each in extents_m) + " mm"
