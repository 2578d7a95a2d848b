"""Learn the shipped library of objects: set each up many times, touch it in every way, and keep what was felt.

Run: ``python -m training.objects [--examples 150]``, an hour and a half on two shared cores; what was felt is kept in
``out/training``, and a stopped run goes on. Sizes are drawn evenly in logarithm from 40 to 125 mm; things stand at any
turn, under a wider chance of friction and torque than the hand's usual one, 1 % noise on the pads. Boxes and pillars
as broad as the hand just holds, which feel most alike, are felt more often. Examples from 1000, 25000, 50000 and 85000
on, what is made by chance from 30000, 35000, 70000 and 75000 on: seeds below 100,000. ``--no-any-turn`` draws what the
hand's usual chance does; the shipped library is made without it. What lies on a side is learned by `training.lying`.
"""

from __future__ import annotations

import argparse
import io
import lzma
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from varishold.errors import InputError
from varishold.exploration import TOUCHES, Felt, Grip, touch_all
from varishold.exploration.hand_library import EXAMPLE_TRUST, GRIP_TRUST
from varishold.exploration.object_examples import example_setting
from varishold.files import atomic_write
from varishold.hand import OBJECTS, HandSetting, PadSetting, Randomization, Step, run_jobs
from varishold.hand.bench import Sensed
from varishold.hand.objects import Pose
from varishold.hand.pads import PadFrames, pad_shape
from varishold.perceive import Evidence, Library, write_library
from varishold.perceive.touch_model import TouchModel

CACHE, CACHE_OF_ANY_POSE = Path("out/training/objects"), Path("out/training/objects-in-any-pose")
OUTPUT = Path("src/varishold/perceive/objects.npz.xz")
SIZES_M = (0.04, 0.125)
PARTS = (1000, 50000)
#: More examples of what is hardest to tell apart, broad boxes and broad pillars, and how broad they are.
BROAD_PARTS, BROAD_M, BROAD = (25000, 85000), (0.092, 0.122), ("box", "square-pillar")
#: Examples of what is made by chance; nothing is named by them, they say what other things feel like.
LUMP_PARTS, ASSEMBLY_PARTS = (30000, 70000), (35000, 75000)
#: What is drawn for things at any turn.
ANY_TURN = Randomization(friction=1.35, torque=1.25, search_rad=float(np.pi))
#: What cannot lie on its side.
HAVE_NO_SIDE = ("sphere",)
# What lies and was not gripped is set up anew so often at most.
_MOST_TRIES = 4
# What examples are rounded to, in standard units, at most and at least, and in parts of the kernel's width; how many at
# either end of a number's range are not. Sizes that grips tell are kept in so many parts of their logarithm, and
# conformities in so many of 1.
_A_UNIT, _LEAST_UNIT, _A_WIDTH, _ENDS, _A_LOG, _A_SCORE = 0.25, 0.05, 0.2, 3, 500, 64
_SWITCHES = len(HandSetting().layout.switches)
_JOINTS, _PADS = HandSetting().design.joints, HandSetting().design.parts


@dataclass(frozen=True)
class Example:
    """One object, set up once: what each touch of it felt like."""

    name: str
    size_m: float
    touches: dict[str, Evidence]
    pose: Pose = "upright"


def draw_example(part: int, k: int, name: str, sizes_m: tuple[float, float] = SIZES_M) -> tuple[float, int]:
    """Return size (metres) and seed of an object's k-th example in a part."""
    letters = sum(map(ord, name))
    rng = np.random.default_rng([part + k, letters])
    size_m = float(np.exp(rng.uniform(*np.log(sizes_m))))
    return size_m, part + 100 * k + letters % 100


def keep(felt: dict[str, Felt]) -> dict[str, np.ndarray]:
    """Return what was felt as arrays, one row a touch of `TOUCHES`; frames in half precision."""
    n = len(TOUCHES)
    kept: dict[str, Any] = {
        "ok": np.zeros(n, np.uint8),
        "sw": np.zeros((n, _SWITCHES), np.uint8),
        "ang": np.full((n, len(_JOINTS)), np.nan, np.float32),
        "h": np.full(n, np.nan, np.float32),
        "force": np.zeros((n, len(_PADS)), np.float32),
        "sc": np.zeros(n, np.float32),
    }
    frames = {}
    for k, touch in enumerate(TOUCHES):
        what = felt.get(touch)
        if what is None or what.step.pads is None:
            continue
        pads, sensed = what.step.pads, what.step.sensed
        kept["ok"][k], kept["sw"][k], kept["ang"][k] = 1, sensed.switches, sensed.angles_rad
        kept["h"][k] = np.nan if what.height_m is None else what.height_m
        kept["force"][k] = [pads.force_n[pad] for pad in _PADS]
        frames[k] = np.concatenate([pads.frames[pad].ravel() for pad in _PADS]).astype(np.float32)
        kept["sc"][k] = np.abs(frames[k]).max() or 1.0
    length = max((len(row) for row in frames.values()), default=0)
    kept["F"] = np.zeros((n, length), np.float16)
    for k, row in frames.items():
        kept["F"][k] = row / kept["sc"][k]
    return kept


def evidence(kept: dict[str, np.ndarray], setting: HandSetting) -> dict[str, Evidence]:
    """Return the evidence of what was kept, by touch."""
    pads = setting.pads or PadSetting()
    shapes = [pad_shape(pad, setting.design, pads) for pad in _PADS]
    ends = np.cumsum([0, *(rows * cols for rows, cols in shapes)])
    pitch = {pad: pads.palm_pitch_m if pad == "palm" else pads.phalanx_pitch_m for pad in _PADS}
    out = {}
    for k, touch in enumerate(TOUCHES.values()):
        if k >= len(kept["ok"]) or not kept["ok"][k]:
            continue
        frames = {
            pad: kept["F"][k, ends[j] : ends[j + 1]].astype(float).reshape(shapes[j]) * float(kept["sc"][k])
            if kept["force"][k, j] >= pads.least_n
            else np.zeros(shapes[j])
            for j, pad in enumerate(_PADS)
        }
        sensed = Sensed(kept["sw"][k].astype(bool), np.zeros(_SWITCHES), kept["ang"][k].astype(float), np.zeros(6))
        height_m = float(kept["h"][k]) if np.isfinite(kept["h"][k]) else None
        step = Step(
            1, touch.name, sensed, felt=True, held=True, pads=PadFrames(frames, pitch, dict.fromkeys(_PADS, 0.0))
        )
        out[touch.name], _ = touch.evidence(Felt(touch, step, height_m), setting)
    return out


@dataclass(frozen=True)
class Job:
    """The k-th example in a part of all objects, or of ten made by chance: keeps what was felt, or takes what was kept.

    `chance`: what is made by chance, "lump" or "assembly".
    """

    part: int
    k: int
    chance: str = ""
    any_turn: bool = False
    lying: bool = False
    broad: bool = False

    @property
    def path(self) -> Path:
        folder = CACHE_OF_ANY_POSE if self.any_turn else CACHE
        what = f"{'lying-' if self.lying else ''}{'broad-' if self.broad else ''}{self.chance and self.chance + 's-'}"
        return folder / f"{what}{self.part}-{self.k}.npz"

    @property
    def names(self) -> tuple[str, ...]:
        first = self.part + 10 * self.k
        if self.chance:
            return tuple(f"{self.chance}-{first + j}" for j in range(10))
        if self.broad:
            return BROAD
        return tuple(name for name in OBJECTS if not self.lying or name not in HAVE_NO_SIDE)

    def drawn(self, name: str) -> tuple[float, int]:
        """Return size (metres) and seed of one of its objects."""
        return draw_example(self.part, self.k, name, BROAD_M if self.broad else SIZES_M)

    @property
    def setting(self) -> HandSetting:
        usual = example_setting()
        return replace(
            usual,
            randomization=ANY_TURN if self.any_turn else usual.randomization,
            pose="lying" if self.lying else "upright",
        )


def feel(job: Job) -> list[Example]:
    """Return the examples of a job."""
    job.path.parent.mkdir(parents=True, exist_ok=True)
    if not job.path.exists():
        _keep_all(job)
    with np.load(job.path, allow_pickle=False) as data:
        of = {
            name: {key.split("/")[1]: data[key] for key in data.files if key.startswith(f"{name}/")}
            for name in job.names
        }
    return [Example(name, job.drawn(name)[0], evidence(of[name], job.setting), job.setting.pose) for name in job.names]


def _keep_all(job: Job) -> None:
    arrays = {}
    for name in job.names:
        size_m, seed = job.drawn(name)
        arrays |= {f"{name}/{key}": value for key, value in keep(_touched(name, size_m, seed, job.setting)).items()}
    with atomic_write(job.path) as file:
        np.savez_compressed(file, **arrays)


def _touched(name: str, size_m: float, seed: int, setting: HandSetting) -> dict[str, Felt]:
    """Touch it in every way; what lies and cannot be gripped is laid elsewhere, as an exploration has it done."""
    felt: dict[str, Felt] = {}
    for tried in range(_MOST_TRIES if setting.pose == "lying" else 1):
        try:
            felt = touch_all(name, size_m, seed=seed + 1_000_000 * tried, setting=setting)
        except InputError:
            # A lump that has no side to lie on.
            break
        if felt:
            break
    return felt


def library_of(examples: list[Example]) -> Library:
    """Return the library that examples make; lumps are its other things."""
    kept = with_failures(examples)
    names = [name for name in OBJECTS if any(example.name == name for example in kept)]
    library = Library.from_examples(
        {name: [list(example.touches.values()) for example in kept if example.name == name] for name in names},
        sizes_m={name: [example.size_m for example in kept if example.name == name] for name in names},
        others=[list(example.touches.values()) for example in kept if example.name not in OBJECTS],
        costs={touch.name: touch.cost for touch in TOUCHES.values()},
    )
    return trusted(library)


def with_failures(examples: list[Example]) -> list[Example]:
    """Return the examples of things that were gripped: after a squeeze that held every other touch was tried."""
    kept = [example for example in examples if example.touches]
    for example in kept:
        if "squeeze" in example.touches:
            missing = [touch for touch in TOUCHES if touch not in example.touches]
            example.touches.update({touch: Evidence(touch, {}, failed=True) for touch in missing})
    return kept


def trusted(library: Library, *, own: float = EXAMPLE_TRUST) -> Library:
    """Return a library that trusts its grips, and each example by itself, no more than they deserve."""
    grips = [name for name, touch in TOUCHES.items() if isinstance(touch, Grip)]
    return library.tempered(GRIP_TRUST, grips, own=own)


def coarse(library: Library, a_unit: float = _A_UNIT) -> Library:
    """Round examples to quarters of their standard unit, or so many, and sizes to a five-hundredth of themselves.

    Nothing is told worse by them, and the file is smaller. A number that alone tells much, as a fingertip's height, is
    rounded less, so that no step of it is a large part of the kernel's width. The ends of what was felt stay where they
    are: what lies beyond them is outside of what is known.
    """

    def rounded(model: TouchModel, values: np.ndarray, *, ends: bool) -> np.ndarray:
        metric = model.metric
        units, told = metric.standardized(values), np.linalg.norm(metric.whitening, axis=1)
        most = _A_WIDTH * model.width * np.sqrt(len(told)) / told
        step = np.clip(np.floor(most / _LEAST_UNIT) * _LEAST_UNIT, _LEAST_UNIT, a_unit)
        round_ = np.round(units / step) * step
        if ends:
            order = np.argsort(np.nan_to_num(units), axis=0, kind="stable")
            for rows in (order[:_ENDS], order[-_ENDS:]):
                np.put_along_axis(round_, rows, np.take_along_axis(units, rows, axis=0), axis=0)
        return round_ * metric.scale + metric.shift

    touches = {
        touch: replace(
            model,
            values=rounded(model, model.values, ends=True),
            others=rounded(model, model.others, ends=False),
            size_values=np.round(model.size_values * _A_LOG) / _A_LOG,
            scores=np.round(model.scores * _A_SCORE) / _A_SCORE,
        )
        for touch, model in library.touches.items()
    }
    return replace(library, touches=touches, log_size=library.log_size.astype(np.float32).astype(np.float64))


def write_packed(library: Library, path: Path) -> None:
    """Write a library as those that are shipped: its arrays as they are, and xz about them."""
    with tempfile.TemporaryDirectory() as folder:
        write_library(library, Path(folder) / "library.npz")
        with np.load(Path(folder) / "library.npz", allow_pickle=False) as kept:
            arrays = {name: kept[name] for name in kept.files}
    stored = io.BytesIO()
    np.savez(stored, **arrays)
    with atomic_write(path) as file:
        file.write(lzma.compress(stored.getvalue(), preset=9 | lzma.PRESET_EXTREME))


def _jobs(options: argparse.Namespace) -> list[Job]:
    """All that is to be felt, of each kind the same share at any time: a library can be made of what there is."""
    shares = [
        (k / number, Job(part, k, any_turn=options.any_turn, chance=chance, broad=broad))
        for parts, number, chance, broad in (
            (PARTS, options.examples, "", False),
            (BROAD_PARTS, options.broad, "", True),
            (LUMP_PARTS, options.lumps, "lump", False),
            (ASSEMBLY_PARTS, options.assemblies, "assembly", False),
        )
        for k in range(number)
        for part in parts
    ]
    return [job for _, job in sorted(shares, key=lambda each: each[0])]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--examples", type=int, default=150, help="examples of each object in each of two parts")
    parser.add_argument("--broad", type=int, default=60, help="of broad boxes and pillars each, in each of two parts")
    parser.add_argument("--lumps", type=int, default=28, help="tens of lumps in each of two parts")
    parser.add_argument(
        "--any-turn",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="turn things all round, or as the hand's usual chance does; the latter needs another --output",
    )
    parser.add_argument("--assemblies", type=int, default=28, help="tens of assemblies in each of two parts")
    parser.add_argument("--processes", type=int, default=None)
    parser.add_argument("--output", type=Path, default=OUTPUT)
    options = parser.parse_args()
    if not options.any_turn and options.output == OUTPUT:
        parser.error("--no-any-turn: give another --output; the shipped library is made without it")
    jobs = _jobs(options)
    begun, examples = time.monotonic(), []
    for done, made in enumerate(run_jobs(jobs, feel, processes=options.processes), start=1):
        examples += made
        left = (time.monotonic() - begun) * (len(jobs) - done) / done
        print(f"\rworlds {done} of {len(jobs)}, {left / 60:.0f} minutes left ", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    library = coarse(library_of(examples))
    write_packed(library, options.output)
    for touch, model in library.touches.items():
        print(f"{touch}: {len(model.metric.names)} numbers, kernel width {model.width:g}, fall {model.fall:g}")
    print(f"{options.output}: {len(library)} examples of {len(library.objects)} objects")


if __name__ == "__main__":
    main()
