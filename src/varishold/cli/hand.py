"""``varishold hand``: grasp an object with the simulated hand, and collect many grasps in a table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Writes
from varishold.cli.hand_file import HandName, hand_named
from varishold.cli.options import refuse_given
from varishold.cli.printing import echo

if TYPE_CHECKING:
    from varishold.hand import Grasp, HandSetting, Job, PadSetting

# Stands for the objects of that table, each with its size.
_TABLE_5 = "table5"
_PLACE = "The object's place is known, so that the hand need not search."
_SCALE = "Length of the digits, as a multiple of the usual."
_STILL = "Leave friction, torques, switches and density as designed; only the object's place varies."


def register(app: Commands) -> None:
    """Add the group to the program."""
    group = app.subgroup("hand", "The simulated hand and its switches (extra 'sim').")
    group.command("grasp")(grasp)
    group.command("collect")(collect)


def grasp(
    name: Annotated[str, Argument("Object, as in square-pillar.", metavar="OBJECT")],
    size_m: Annotated[float, Option("Diameter or breadth in metres.")],
    seed: Annotated[int, Option("The same seed gives the same grasp.")] = 0,
    place_known: Annotated[bool, Option(_PLACE)] = False,
    finger_scale: Annotated[float, Option(_SCALE)] = 1.0,
    hand: HandName = None,
    still: Annotated[bool, Option(_STILL)] = False,
    picture: Annotated[
        Path | None,
        Option("Write a picture of the five steps (PNG) here."),
        Writes("picture", ending=".png"),
    ] = None,
    pads: Annotated[
        Path | None,
        Option("Write the taxel pads' frames (NPZ recording) here."),
        Writes("recording", ending=".npz"),
    ] = None,
    json: Annotated[bool, Option("Print one JSON object a step, and one at the end.")] = False,
) -> None:
    """Search for an object, grasp it in the paper's five steps, and say what the hand feels."""
    from varishold.cli.printing import print_json
    from varishold.hand import OBJECTS, PadSetting, grasp_object, photograph
    from varishold.hand.rows import grasp_to_dicts, pads_recording

    if name not in OBJECTS and name.replace("_", "-") in OBJECTS:
        name = name.replace("_", "-")
    setting = _setting(
        hand,
        finger_scale,
        search=not place_known,
        still=still,
        pads=None if pads is None else PadSetting(),
    )
    if picture is None:
        done = grasp_object(name, size_m, seed=seed, setting=setting, pad_steps=(1, 2, 3, 4, 5))
    else:
        done = photograph(name, size_m, picture, seed=seed, setting=setting, pad_steps=(1, 2, 3, 4, 5))
    if json:
        for line in grasp_to_dicts(done, setting):
            print_json(line)
    else:
        _print_grasp(done, setting)
    if pads is not None:
        from varishold.recording import write

        write(pads_recording(done.steps), pads)
    for path, what in ((picture, "picture"), (pads, "pads")):
        if path is not None and not json:
            echo(f"{what}: {path}")


def collect(
    objects: Annotated[
        list[str],
        Option("NAME, NAME:SIZE_M, several between commas, or table5; may be repeated."),
    ],
    output: Annotated[Path, Option("The grasp table to write (CSV).", short="-o"), Writes("grasps")],
    grasps: Annotated[int, Option("Grasps an object.", min=1, max=100_000)] = 10,
    more: Annotated[list[str] | None, Argument("More objects.", metavar="[OBJECT]...")] = None,
    size_m: Annotated[
        list[float] | None, Option("Sizes in metres of objects named without one; may be repeated.")
    ] = None,
    seed: Annotated[int, Option("Seed of the first grasp of each object.")] = 0,
    steps: Annotated[str, Option("Steps that get a row: numbers between commas, or all.")] = "5",
    place_known: Annotated[bool, Option(_PLACE)] = False,
    finger_scale: Annotated[float, Option(_SCALE)] = 1.0,
    hand: HandName = None,
    still: Annotated[bool, Option(_STILL)] = False,
    processes: Annotated[int | None, Option("Processes; default: one a processor.")] = None,
    force: Annotated[bool, Option("Replace the file that is there, whatever it is.")] = False,
) -> None:
    """Grasp objects many times and write a grasp table; a table that is there is carried on."""
    from varishold.cli.progress import progress_bar
    from varishold.hand import collect_grasps

    named = _words([*objects, *(more or [])])
    if all(word == _TABLE_5 or ":" in word for word in named):
        refuse_given("size_m", because="is of objects that are named without a size, and all have one: leave it out")
    jobs = _jobs(named, size_m or [0.07], grasps, seed)
    setting = _setting(hand, finger_scale, search=not place_known, still=still)
    with progress_bar("grasps", len(jobs)) as update:
        table = collect_grasps(
            jobs,
            output,
            setting=setting,
            steps=_steps(steps, setting),
            processes=processes,
            progress=lambda done, _: update(completed=done),
            anew=force,
        )
    held = table.cells["held"]
    echo(f"{output}: {counted(len(table), 'row')}, {int(held.sum())} held")


def _words(objects: list[str]) -> list[str]:
    return [word for text in objects for word in text.replace(",", " ").split()]


def _jobs(objects: list[str], sizes_m: list[float], grasps: int, seed: int) -> list[Job]:
    from varishold.errors import InputError
    from varishold.hand import TABLE_5_OBJECTS, Job

    wanted: list[tuple[str, float]] = []
    for word in _words(objects):
        name, sized, size = word.partition(":")
        if word == _TABLE_5:
            wanted.extend(TABLE_5_OBJECTS)
        elif sized:
            try:
                wanted.append((name, float(size)))
            except ValueError:
                raise InputError(f"--objects takes NAME:SIZE_M as in cylinder:0.09, got {word!r}") from None
        else:
            wanted.extend((name, size_m) for size_m in sizes_m)
    return [Job(name, size_m, seed + k) for name, size_m in wanted for k in range(grasps)]


def _setting(name: str | None, finger_scale: float, *, pads: PadSetting | None = None, **more: Any) -> HandSetting:
    from dataclasses import replace

    from varishold.hand import HandDesign, hand_setting

    hand = hand_named(name, finger_scale=finger_scale, pads_for=None if pads is None else "--pads")
    setting = replace(hand_setting(hand, **more), pads=pads)
    return replace(setting, design=HandDesign(finger_scale=finger_scale)) if hand is None else setting


def _steps(text: str, setting: HandSetting) -> tuple[int, ...]:
    from varishold.errors import InputError

    if text.strip() == "all":
        return tuple(setting.design.steps)
    try:
        return tuple(sorted({int(word) for word in text.split(",")}))
    except ValueError:
        raise InputError(f"--steps takes numbers between commas, as in 3,5, or all, got {text!r}") from None


def _print_grasp(done: Grasp, setting: HandSetting) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console()
    parts: dict[str, list[int]] = {}
    for k, switch in enumerate(setting.layout.switches):
        parts.setdefault(switch.part.split(".")[0], []).append(k)
    for number, attempt in enumerate(done.attempts, start=1):
        if attempt.search is not None:
            found = "found" if attempt.search.found else "not found"
            console.print(
                f"search: {found}, felt from both sides {counted(attempt.search.touches, 'time')}, "
                f"moved aside {attempt.search.shift_m * 1e3:+.0f} mm",
                highlight=False,
            )
        table = Table(header_style="bold", box=None, pad_edge=False)
        for heading in ("step", *parts, "feels"):
            table.add_column(heading)
        for step in attempt.steps:
            marks = ["".join("●" if step.sensed.switches[k] else "·" for k in ks) for ks in parts.values()]
            table.add_row(f"{step.number} {step.name}", *marks, "held" if step.felt else "nothing")
        console.print(table)
        if attempt.outcome != "held":
            again = "; again" if number < len(done.attempts) else ""
            console.print(f"attempt {number}: {attempt.outcome}{again}", style="yellow")
    truth = "hangs in the hand" if done.held else "is not in the hand"
    console.print(f"the {done.name} of {done.size_m * 1e3:g} mm {truth}", highlight=False)
