"""``varishold perceive``: touch an object with the simulated hand until it is known."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.hand_file import HandName, hand_named, require_library_of
from varishold.cli.printing import echo, printable, tell
from varishold.cli.taxels import TaxelWords, library_of, taxels_of

if TYPE_CHECKING:
    from varishold.exploration import Exploration, MadeTouch, SurfaceExploration
    from varishold.hand import Bench, HandSetting, Step
    from varishold.hand.mjcf import MjcfHand
    from varishold.perceive import Library, Perceiver
    from varishold.report.photo import Photo

# Objects that a printed line names at most, and the probability below which it leaves them out.
_NAMED, _LEAST_NAMED = 3, 0.005

_OBJECT = (
    "One of the ten objects: cylinder, square-pillar, box, hexagonal-prism, triangular-prism, sphere, cone, pyramid, "
    "cone-frustum, pyramid-frustum; a thing it does not know: half-cylinder, l-block, torus, ellipsoid, lump-NUMBER; "
    "or a mesh (.stl, .obj, .ply)."
)


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(perceive)


def perceive(
    name: Annotated[str, Argument(_OBJECT, metavar="OBJECT"), Reads("word")],
    size_m: Annotated[
        float | None,
        Option("Diameter or breadth in metres; of a mesh its larger level extent, to which it is scaled."),
    ] = None,
    seed: Annotated[int, Option("The same seed gives the same sequence.")] = 0,
    error: Annotated[float, Option("The error that is accepted: it stops when it is so sure.")] = 0.01,
    most_touches: Annotated[int, Option("It stops after so many touches.", min=1)] = 4,
    order: Annotated[
        str | None,
        Option("Touches in a fixed order, as in grasp,fingertip-edge, instead of choosing each."),
    ] = None,
    place_known: Annotated[bool, Option("The object's place is known, so that the hand need not search.")] = False,
    lying: Annotated[
        bool,
        Option("It lies on a side, in proportions and on a side drawn by the seed; no mesh does."),
    ] = False,
    called: Annotated[
        str | None,
        Option("What a mesh truly is, to tell a right answer. Default: its file's name.", name="--name"),
    ] = None,
    library: Annotated[
        Path | None,
        Option("What is known of objects (NPZ of write_library); default: ten objects."),
        Reads(),
    ] = None,
    taxels: TaxelWords = None,
    hand: HandName = None,
    prior: Annotated[
        Path | None,
        Option("What a camera says of the object before it is touched (JSON: source, probability by name)."),
        Reads(),
    ] = None,
    strangers: Annotated[
        float,
        Option("How many of the things you meet the library does not know, a share: the probability leaves so much."),
    ] = 0.1,
    surface: Annotated[
        Path | None,
        Option("Clamp it afterwards, feel its whole surface, and write that here as a mesh (STL, metres)."),
        Writes("surface", ending=".stl"),
    ] = None,
    touches: Annotated[int | None, Option("How many touches the surface takes, 2 to 16. Default: 12.")] = None,
    report: Annotated[Path | None, Option("Write a self-contained HTML report here."), Writes("page")] = None,
    json: Annotated[bool, Option("Print one JSON object a touch, and the answer at the end.")] = False,
) -> None:
    """Touch an object with the simulated hand until it is known: say after each touch what is believed, and why.

    Touches: grasp, squeeze, regrasp-higher, regrasp-lower, regrasp-turned-45, regrasp-turned-90, fingertip-edge,
    fingertip-middle, fingertip-beyond.
    """
    from varishold.cli.felt_surface import answer_and_feel, touches_wanted
    from varishold.cli.thing import thing_to_touch
    from varishold.exploration import perceive as touch_until_known
    from varishold.hand import PadSetting, hand_setting
    from varishold.hand.objects import laid_to_grip
    from varishold.perceive import Perceiver, read_prior, shipped_library

    own = hand_named(hand, pads_for=None if surface is None else "--surface")
    setting = hand_setting(
        own, search=not place_known, pads=PadSetting(taxels=taxels_of(taxels)), pose="lying" if lying else "upright"
    )
    thing, size_m = thing_to_touch(name, size_m, called, quiet=json, hand=setting.design)
    if lying:
        laid_to_grip(thing, size_m, seed=seed)
    known = _library(library, taxels, hand, own, setting.pose, quiet=json)
    perceiver = Perceiver(
        known,
        error=error,
        most_touches=most_touches,
        prior=None if prior is None else read_prior(prior, (known or shipped_library(setting.pose)).objects),
        strangers=strangers,
        pose=setting.pose,
    )
    if lying and "lying" not in perceiver.library.pose_of_kind:
        tell("note: the library was felt of things that stand; most that lies is none of these")
    in_order, for_surface = _order(order, perceiver, setting), touches_wanted(touches, surface)
    album = None if report is None else _Album(report)
    show = _Show(json, "grasp" if in_order is None else in_order[0])
    with show:
        sequence = touch_until_known(
            thing,
            size_m,
            seed=seed,
            perceiver=perceiver,
            setting=setting,
            order=in_order,
            on_touch=show.touch,
            watch=None if album is None else album.watch,
        )
    felt = answer_and_feel(
        lambda more: show.answer(sequence, more if own is None else {"hand": own.name} | more),
        thing,
        size_m,
        surface,
        seed=seed,
        touches=for_surface,
        setting=setting,
        json=json,
    )
    if album is not None:
        album.write_page(sequence, setting=setting, error=error, surface=felt)
        if not json:
            echo(f"report: {report}")


def _library(
    path: Path | None, taxels: str | None, named: str | None, own: MjcfHand | None, pose: str, *, quiet: bool
) -> Library | None:
    """Return the library of a file, or None for the shipped one; either must be of the hand that touches."""
    from varishold.hand import HandDesign
    from varishold.perceive import shipped_library

    if path is None and own is not None and own.library is not None:
        path = Path(own.library)
    where = "the shipped library" if path is None else str(path)
    if path is None and own is not None:
        require_library_of(own, shipped_library(), where=where, given=str(named))
    library = library_of(path, taxels, pose, quiet=quiet)
    if library is not None:
        require_library_of(own or HandDesign(), library, where=where, given=str(named))
    return library


def _order(text: str | None, perceiver: Perceiver, setting: HandSetting) -> tuple[str, ...] | None:
    """Return the names of touches in a text, checked, so that nothing fails half-way."""
    from varishold.errors import InputError
    from varishold.exploration import TOUCHES
    from varishold.exploration.touches import touches_of

    known = [touch for touch in touches_of(setting.design) if touch in perceiver.library.touches]
    if text is None:
        if "grasp" not in known:
            raise InputError(
                "the library must know the first touch, grasp, or --order must begin with another; "
                f"it knows {', '.join(perceiver.library.touches)}"
            )
        return None
    touches = tuple(word.strip().replace("_", "-") for word in text.split(","))
    for touch in touches:
        if touch not in known:
            raise InputError(f"--order takes touches between commas, of {', '.join(known)}; got {touch!r}")
    twice = next((touch for k, touch in enumerate(touches) if touch in touches[:k]), None)
    if twice is not None:
        raise InputError(f"--order takes each touch once; got {twice!r} again")
    if not TOUCHES[touches[0]].begins:
        raise InputError(f"--order must begin with grasp or squeeze, for nothing is held before; got {touches[0]!r}")
    return touches


class _Album:
    """Keeps the scene of each touch, and a picture of it as long as something here can draw, for the page at a path."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._scenes: list[Any] = []
        self._why_not: str | None = None
        self._photographer: Any = None
        self._taken: list[Photo] = []

    def watch(self, bench: Bench, step: Step) -> None:
        from varishold.errors import MissingExtraError
        from varishold.hand.picture import Photographer
        from varishold.hand.scene import take_scene
        from varishold.report.scene_data import CAMERA

        self._scenes.append(take_scene(bench))
        if self._why_not is not None:
            return
        try:
            if self._photographer is None:
                self._photographer = Photographer(bench, CAMERA)
            self._taken.append(self._photographer.take(bench))
        except MissingExtraError as error:
            self._why_not = str(error)

    def write_page(
        self, sequence: Exploration, *, setting: HandSetting, error: float, surface: SurfaceExploration | None
    ) -> None:
        """Give the drawing context back, and write the page with what was kept."""
        from varishold.report import write_perceive_report

        if self._photographer is not None:
            self._photographer.close()
        write_perceive_report(
            self._path,
            sequence,
            setting=setting,
            pictures=self._taken,
            scenes=self._scenes,
            no_pictures=self._why_not,
            error=error,
            surface=surface,
        )


class _Show:
    """Prints touches as they happen, and the answer."""

    def __init__(self, json: bool, first: str) -> None:
        from rich.console import Console

        self._json = json
        self._n = 0
        self._trace: list[dict[str, Any]] = []
        self._console = Console(highlight=False)
        # Shown on a terminal only, and gone when the touch is complete.
        self._status = Console(stderr=True).status(f"touch 1: {first} …") if sys.stderr.isatty() else None

    def __enter__(self) -> None:
        if self._status is not None:
            self._status.start()

    def __exit__(self, *_: object) -> None:
        self._clear()

    def _clear(self) -> None:
        if self._status is not None:
            self._status.stop()

    def touch(self, touch: MadeTouch) -> None:
        """Show one touch."""
        from varishold.cli.printing import print_json

        self._n += 1
        # Its line would stand before ours.
        self._clear()
        if self._json:
            self._trace.append(touch_to_dict(touch))
            print_json(self._trace[-1])
            sys.stdout.flush()
        else:
            for style, line in touch_lines(self._n, touch):
                self._console.print(printable(line), style=style, markup=False, soft_wrap=True)
        if self._status is not None and touch.then is not None:
            self._status.update(f"touch {self._n + 1}: {touch.then[0]} …")
            self._status.start()

    def answer(self, sequence: Exploration, more: dict[str, Any] | None = None) -> None:
        """Show the answer, and whether it is true; as JSON with more beside it."""
        from varishold.cli.printing import print_json
        from varishold.report.exploration_words import answer_in_words, truth_in_words, was_right
        from varishold.report.senses import senses_in_words

        if self._json:
            print_json(answer_to_dict(sequence, self._trace) | (more or {}))
            return
        for remark in () if sequence.perception is None else sequence.perception.remarks:
            self._console.print(printable(f"note: {remark}"), style="yellow", markup=False, soft_wrap=True)
        for line in senses_in_words(sequence):
            self._console.print(printable(line), markup=False, soft_wrap=True)
        self._console.print(answer_in_words(sequence), style="bold", markup=False, soft_wrap=True)
        style = {True: "green", False: "red", None: None}[was_right(sequence)]
        self._console.print(truth_in_words(sequence), style=style, markup=False, soft_wrap=True)


def touch_lines(number: int, touch: MadeTouch) -> list[tuple[str | None, str]]:
    """Return style and text of the lines about one touch."""
    from varishold.report.exploration_words import next_in_words, size_in_words, verdict_in_words

    update, felt = touch.update, touch.felt
    likely = [
        f"{name} {p:.2f}"
        for rank, (name, p) in enumerate(update.probability.items())
        if rank == 0 or (rank < _NAMED and p >= _LEAST_NAMED)
    ]
    size = size_in_words(update.size_m, update.size_interval_m)
    told = felt.touch.felt_in_words(felt, touch.surfaces)
    took = "" if touch.seconds is None else f" ({touch.seconds:.1f} s)"
    lines: list[tuple[str | None, str]] = [
        ("bold", f"{number} {felt.touch.name}: {felt.touch.done}; {told}{took}"),
        (None, f"  {', '.join(likely)}; {size}"),
        (None, f"  {verdict_in_words(touch)}: {update.why}"),
    ]
    following = next_in_words(touch)
    if following is not None:
        lines.append(("dim", f"  next: {following}"))
    return lines


def touch_to_dict(touch: MadeTouch) -> dict[str, Any]:
    """Return a touch as a JSON line."""
    from varishold.touch import SURFACES

    update, sensed = touch.update, touch.felt.step.sensed
    pads = {
        pad: None
        if surface is None
        else {
            "surface": surface.name,
            "probability": dict(zip(SURFACES, (float(p) for p in surface.posterior()), strict=True)),
            "radius_m": surface.radius_m,
            "force_n": surface.force_n,
        }
        for pad, surface in touch.surfaces.items()
    }
    return {
        "touch": update.touch,
        "probabilities": update.probability,
        "size_m": update.size_m,
        "size_interval_m": None if update.size_interval_m is None else list(update.size_interval_m),
        "p_value": update.p_value,
        "verdict": update.verdict,
        "why": update.why,
        "reasons": list(update.reasons),
        "chosen_for_nats": touch.chosen_for,
        "next": _next_to_dict(touch),
        "seconds": touch.seconds,
        "switches_closed": int(sensed.switches.sum()),
        "height_m": touch.felt.height_m,
        "pads": pads,
    }


def _next_to_dict(touch: MadeTouch) -> dict[str, Any] | None:
    if touch.then is None:
        return None
    (name, nats), planned = touch.then, touch.planned
    return {
        "touch": name,
        "expected_nats": nats,
        "expected_seconds": None if planned is None else planned.seconds,
        "along_with": None if planned is None else planned.along_with,
    }


def answer_to_dict(sequence: Exploration, trace: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the last JSON line: the answer, how it came about, and the truth that the simulation knows."""
    from varishold.report.exploration_words import was_right

    perception = sequence.perception
    interval = None if perception is None else perception.size_interval_m
    return {
        "object": None if perception is None else perception.object,
        "size_m": None if perception is None else perception.size_m,
        "probability": None if perception is None else perception.probability,
        "alternatives": {} if perception is None else perception.alternatives,
        "touches": len(sequence.touches),
        "trace": trace,
        "size_interval_m": None if interval is None else list(interval),
        "pose": None if perception is None else perception.pose,
        "verdict": None if perception is None else perception.trace[-1].verdict,
        "why": None if perception is None else perception.trace[-1].why,
        "senses": [{"source": who, "probabilities": said} for who, said in sequence.senses],
        "drops": sequence.drops,
        "remarks": ["nothing was gripped"] if perception is None else list(perception.remarks),
        "true_object": sequence.name,
        "true_size_m": sequence.size_m,
        "right": was_right(sequence),
        "seed": sequence.seed,
        "seconds": sequence.seconds,
    }
