"""``varishold skin``: press a solid into a skin, and collect many labelled presses in a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.printing import echo

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from varishold.skin import PressedSolid, Skin
    from varishold.solids import Solid

_SKIN = "Skin file (TOML); default: a layer of 6 mm, Poisson's ratio .45, taxels 1 mm deep."
_MAP_SUFFIXES = (".npy", ".csv", ".txt")
# Whoever names a larger thing for a pad means millimetres.
_LARGEST_M = 1.0


def register(app: Commands) -> None:
    """Add the group to the program."""
    group = app.subgroup("skin", "The simulated skin: press solids into it.")
    group.command("press")(press)
    group.command("collect")(collect)


def press(
    solid: Annotated[
        str,
        Argument("Solid, as in square-pillar, or a height map in metres (NPY, CSV).", metavar="SOLID"),
        Reads(),
    ],
    size_m: Annotated[float | None, Option("Diameter or breadth of the solid in metres.")] = None,
    skin: Annotated[Path | None, Option(_SKIN), Reads()] = None,
    depth_m: Annotated[float | None, Option("How deep to press, metres; default: 1 mm.")] = None,
    force_n: Annotated[float | None, Option("How hard to press, newton, instead of a depth.")] = None,
    x_m: Annotated[float, Option("Where the solid lies: along the columns, metres.")] = 0.0,
    y_m: Annotated[float, Option("Where the solid lies: along the rows, metres.")] = 0.0,
    yaw_rad: Annotated[float, Option("The solid's turn from +x toward +y, radians.")] = 0.0,
    tip_x: Annotated[float, Option("Slope of the face along x.")] = 0.0,
    tip_y: Annotated[float, Option("Slope of the face along y.")] = 0.0,
    shape: Annotated[str, Option("Rows x columns of the pad.")] = "32x32",
    pitch_m: Annotated[float, Option("Taxel spacing in metres.")] = 1e-3,
    noise: Annotated[float, Option("Noise of the taxels, as a share of the frame's peak.")] = 0.0,
    seed: Annotated[int, Option("Seed of the noise.", min=0)] = 0,
    picture: Annotated[Path | None, Option("Write a picture (PNG) here."), Writes("picture", ending=".png")] = None,
    output: Annotated[
        Path | None,
        Option("Write the press (NPZ recording) here.", short="-o"),
        Writes("press", ending=".npz"),
    ] = None,
    json: Annotated[bool, Option("Print one JSON object.")] = False,
) -> None:
    """Press one solid into a skin and say what the pad under it feels."""
    from varishold.cli.printing import parse_shape, print_json
    from varishold.errors import InputError
    from varishold.skin import Taxels, reconstruct, sense
    from varishold.skin import press as solve
    from varishold.solids import Pose

    body = _body(solid, size_m)
    known = _skin(skin)
    if depth_m is None and force_n is None:
        depth_m = 1e-3
    pose = Pose(x_m, y_m, yaw_rad, tip_x, tip_y)
    mapped = not hasattr(body, "top_m")
    if mapped and pose != Pose():
        raise InputError("a height map lies where it is; --x-m, --y-m, --yaw-rad and --tip-* are for solids")
    pressed = solve(
        body,
        known,
        depth=depth_m,
        force=force_n,
        shape=parse_shape(shape) or (32, 32),
        pitch_m=pitch_m,
        pose=None if mapped else pose,
    )
    frame = sense(pressed, Taxels(noise=noise), seed=seed)
    unit = "raw" if known.youngs_modulus_pa is None else "Pa"
    if output is not None:
        _write(output, pressed, frame, unit)
    if picture is not None:
        from varishold.report.press_figure import write_press_figure

        relief = reconstruct(frame, known, pitch=pitch_m)
        title = f"{solid} pressed {1e3 * pressed.depth_m:.3g} mm into a {known.kind}"
        write_press_figure(picture, pressed, frame, relief=relief, title=title)
    side_y, side_x = (a / b * c for a, b, c in zip(pressed.shape, pressed.pressure.shape, pressed.pitch_m, strict=True))
    answer = {
        "solid": solid,
        "depth_m": pressed.depth_m,
        "force_n": pressed.force_n if known.youngs_modulus_pa is not None else None,
        "area_m2": float(pressed.contact.sum()) * side_x * side_y,
        "peak_pressure": float(pressed.pressure.max()),
        "peak_taxel": float(frame.max()),
        "unit": unit,
        "rms_gap": pressed.rms_gap,
        "converged": pressed.converged,
    }
    if json:
        print_json(answer)
        return
    force = "unknown (the skin has no modulus)" if answer["force_n"] is None else f"{pressed.force_n:.4g} N"
    echo(
        f"depth {1e3 * pressed.depth_m:.3g} mm, force {force}, contact {1e6 * float(answer['area_m2']):.4g} mm2\n"
        f"pressure at most {pressed.pressure.max():.4g}, at the taxels {frame.max():.4g} "
        f"({'Pa' if unit == 'Pa' else 'in units of the contact modulus'})"
    )
    for path, what in ((picture, "picture"), (output, "recording")):
        if path is not None:
            echo(f"{what}: {path}")


def collect(
    output: Annotated[
        Path,
        Option("The labelled recording to write (NPZ).", short="-o"),
        Writes("presses", ending=".npz"),
    ],
    count: Annotated[int, Option("Presses.", min=1)] = 1000,
    solids: Annotated[str, Option("Solids between commas, or all.")] = "all",
    skin: Annotated[Path | None, Option(_SKIN), Reads()] = None,
    shape: Annotated[str, Option("Rows x columns of the pad.")] = "32x32",
    pitch_m: Annotated[float, Option("Taxel spacing in metres.")] = 1e-3,
    size_taxels: Annotated[
        tuple[float, float] | None,
        Option(
            "Least and greatest breadth of a contact, taxels; default: 1/4 and 5/8 of the pad.",
            metavar="LEAST GREATEST",
        ),
    ] = None,
    slope: Annotated[
        tuple[float, float], Option("Least and greatest depth over breadth.", metavar="LEAST GREATEST")
    ] = (0.05, 0.3),
    noise: Annotated[float, Option("Noise of the taxels, as a share of each frame's peak.")] = 0.01,
    crosstalk: Annotated[float, Option("Share that leaks into each of four neighbours.")] = 0.0,
    gain_spread: Annotated[float, Option("Spread of the taxels' gains.")] = 0.0,
    bits: Annotated[int | None, Option("Bits of a reading.")] = None,
    dead: Annotated[float, Option("Share of dead taxels.")] = 0.0,
    stuck: Annotated[float, Option("Share of stuck taxels.")] = 0.0,
    seed: Annotated[int, Option("The same seed gives the same file.", min=0)] = 0,
    processes: Annotated[int | None, Option("Processes; default: one a processor.", min=1)] = None,
) -> None:
    """Press random solids and write a labelled recording; an interrupted call is carried on by the same call."""
    import os

    from varishold.cli.printing import parse_shape
    from varishold.cli.progress import progress_bar
    from varishold.skin import PressDraw, Taxels, collect_presses
    from varishold.solids import SOLIDS

    pad = parse_shape(shape) or (32, 32)
    draw = PressDraw(
        skin=_skin(skin),
        shape=pad,
        pitch_m=pitch_m,
        solids=tuple(SOLIDS) if solids == "all" else tuple(word.strip() for word in solids.split(",")),
        size_taxels=size_taxels or (min(pad) / 4, min(pad) * 5 / 8),
        slope=slope,
        taxels=Taxels(noise=noise, crosstalk=crosstalk, gain_spread=gain_spread, bits=bits, dead=dead, stuck=stuck),
    )
    with progress_bar("presses", count) as update:
        found = collect_presses(
            output,
            draw,
            count,
            seed=seed,
            processes=processes or os.cpu_count() or 1,
            advance=lambda done: update(advance=done),
        )
    went_on = f", {found} of them from an interrupted call" if found else ""
    echo(f"{output}: {counted(count, 'press')}{went_on}")


def _skin(path: Path | None) -> Skin:
    from varishold.skin import Skin, read_skin

    return Skin("layer", 6e-3, 0.45, 1e-3) if path is None else read_skin(path)


def _body(name: str, size_m: float | None) -> Solid | NDArray[np.float64]:
    from varishold.errors import InputError
    from varishold.recording import read_height_map
    from varishold.solids import SOLIDS
    from varishold.solids.registry import known_solid, solid_of_size

    if not name.lower().endswith(_MAP_SUFFIXES):
        form = name.replace("_", "-")
        if form not in SOLIDS and Path(name).exists():
            raise InputError(f"{name}: the name of a height map ends in {', '.join(_MAP_SUFFIXES)}")
        known_solid(form)
        if size_m is None:
            raise InputError(f"a {name} needs --size-m, its diameter or breadth in metres")
        if _LARGEST_M < size_m < float("inf"):
            raise InputError(f"a {name} is {_LARGEST_M:g} m large at most, got {size_m:g}; write --size-m in metres")
        return solid_of_size(form, size_m)
    if size_m is not None:
        raise InputError("a height map has its own size; --size-m is for solids")
    heights = read_height_map(name)
    if (high := float(heights.max() - heights.min())) > _LARGEST_M:
        raise InputError(f"{name}: is {high:g} m high, of {_LARGEST_M:g} m at most; write heights in metres")
    return heights


def _write(path: Path, pressed: PressedSolid, frame: NDArray[np.float64], unit: str) -> None:
    import numpy as np

    from varishold.files import write_archive
    from varishold.recording.formats.named_arrays import TRUTH

    write_archive(
        {
            "pressure": frame[None],
            "pitch_m": np.array(pressed.pitch_m),
            "unit": np.array(unit),
            "sensor": np.array(f"simulated {pressed.skin.kind}"),
            "press": np.zeros(1, dtype=np.int64),
            "press.depth_m": np.array([pressed.depth_m]),
            "press.force_n": np.array([pressed.force_n]),
            f"{TRUTH}pressure": pressed.pressure,
            f"{TRUTH}displacement_m": pressed.displacement_m,
            f"{TRUTH}gap_m": pressed.gap_m,
            f"{TRUTH}x_m": pressed.x_m,
            f"{TRUTH}y_m": pressed.y_m,
        },
        path,
        kind="press",
    )
