"""What own presses taught, as C99: a controller names the user's things as Python does."""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.compiled_once import words
from tests.pressed_things import failed, recording, told
from tests.test_learning_portable_file import KNOWN, NEW, two_pads
from tests.test_touch_export import COMPILER, FAST, SHORT, STRICT, built, needs_board, needs_compiler, on_a_board

from varishold import write
from varishold.errors import InputError
from varishold.learning import PortableClassifier, labelled_presses
from varishold.learning.portable import strongest_frames
from varishold.sensor import Power, Sensor
from varishold.touch.contact_network import NONE_OF_THESE
from varishold.touch.course.presses import Press
from varishold.touch.writers import Export, c99_files, export
from varishold.touch.writers.c99 import _text
from varishold.touch.writers.vectors import check_vectors


@pytest.fixture(scope="module")
def model() -> PortableClassifier:
    return PortableClassifier().fit(KNOWN.presses, KNOWN.labels)


SENSORS = {
    "none": None,
    "down": Sensor(polarity="down", rest=1023, span=1000, full_scale=500.0, pitch_m=(0.002, 0.002)),
    "rest map": Sensor(shape=(13, 15), rest=np.arange(195.0).reshape(13, 15) % 7, pitch_m=(0.002, 0.003)),
    "response": Sensor(response=Power(0.7), span=200, dead_band=0.1, saturation=0.9, crosstalk=0.05),
}


@needs_compiler
@pytest.mark.usefixtures("compiled_once")
@pytest.mark.parametrize("sensor", SENSORS)
def test_names_are_those_of_python(tmp_path: Path, model: PortableClassifier, sensor: str) -> None:
    wanted = Export(sensor=SENSORS[sensor], weights="float32", parameters=model.networks["thumb"])
    # Frames that were learned from, drawn solids, and an empty one.
    assert built(tmp_path, wanted, *([] if sensor == "response" else [SHORT])) == "38 of 38 names as in Python"


def test_at_other_thresholds_than_it_was_learned_at_it_is_refused(model: PortableClassifier) -> None:
    with pytest.raises(InputError, match="was learned at 32 thresholds a contact, got levels 16; leave"):
        Export(levels=16, parameters=model.networks["thumb"])


@needs_compiler
@pytest.mark.usefixtures("compiled_once")
def test_a_pad_with_gaps_has_names_as_in_python(tmp_path: Path, model: PortableClassifier) -> None:
    wanted = Export(weights="float32", parameters=model.networks["palm"])
    assert wanted.shape == (9, 11)
    assert "static const uint8_t field[]" in c99_files(wanted)["pad.c"]
    assert built(tmp_path, wanted, SHORT) == "38 of 38 names as in Python"


@needs_compiler
@pytest.mark.usefixtures("compiled_once")
@pytest.mark.parametrize(("weights", "fewest"), [("float32", 400), ("int8", 396)])
def test_over_many_fresh_presses_hardly_a_name_is_another(tmp_path: Path, weights: str, fewest: int) -> None:
    known = labelled_presses([recording(["disc", "bar"] * 12, 0)], label="thing")
    clf = PortableClassifier().fit(known.presses, known.labels)
    # Rings it has not learned.
    fresh = labelled_presses([recording(["bar", "ring", "disc", "disc"] * 100, 1)], label="thing")
    frames = np.array([strongest_frames(press)["pad"] for press in fresh.presses])
    network = replace(clf.networks["pad"], examples=frames.astype(np.float32))
    wanted = Export(weights=weights, parameters=network)  # type: ignore[arg-type]
    vectors = check_vectors(wanted)[: len(frames)]
    # What the test compares with is what the classifier says of whole presses.
    said = np.where(clf.refused(fresh.presses), NONE_OF_THESE, clf.predict(fresh.presses))
    assert [network.names[vector.name] for vector in vectors] == said.tolist()
    assert set(said.tolist()) == set(network.names)
    for name, text in c99_files(wanted, vectors).items():
        (tmp_path / name).write_text(text)
    done = subprocess.run(["make", "-s", "test", SHORT], cwd=tmp_path, capture_output=True, text=True, check=False)
    same = re.match(r"(\d+) of 400 names as in Python", done.stdout.splitlines()[-1])
    assert same is not None, done.stdout + done.stderr
    assert int(same[1]) >= fewest


@needs_compiler
def test_pads_that_say_their_parts_agree_with_the_classifier_of_all(
    tmp_path: Path, model: PortableClassifier, compiled: Path
) -> None:
    """Several pads, each exported by itself, are linked into one program that multiplies what they say."""
    compiler = (*words(compiled, str(COMPILER)), *STRICT, *FAST)
    names = tuple(model.networks)
    objects = []
    for name in names:
        export(Export(weights="float32", parameters=model.networks[name]), "c", tmp_path / name)
        objects.append(tmp_path / f"{name}.o")
        own = (f"-Dpad={name}", f"-Dpad_names={name}_names")
        source = str(tmp_path / name / "pad.c")
        subprocess.run([*compiler, *own, "-c", source, "-o", str(objects[-1])], check=True)
    shared = tmp_path / names[0]
    kernel = [str(file) for file in shared.glob("*.c") if file.name not in ("pad.c", "main.c", "test.c", "vectors.c")]
    program = shared / "both.c"
    program.write_text((Path(__file__).parent / "two_pads.c").read_text())
    command = [*compiler, str(program), *kernel, *map(str, objects), "-lm"]
    subprocess.run([*command, "-o", str(tmp_path / "both")], check=True)
    presses = [*NEW.presses, *strangers()]
    readings = [np.concatenate([strongest_frames(one)[name].ravel() for name in names]) for one in presses]
    text = "\n".join(" ".join(f"{v:.7g}" for v in row) for row in readings)
    done = subprocess.run([str(tmp_path / "both")], input=text, capture_output=True, text=True, check=True)
    plain, refused = model._said(presses)[0], model.refused(presses)
    assert 0 < refused.sum() < len(presses)
    for line, p, strange in zip(done.stdout.splitlines(), plain, refused, strict=True):
        name, *shares = line.split()
        assert int(name) == (len(p) if strange else p.argmax())
        if not strange:
            np.testing.assert_allclose([float(share) for share in shares], p, atol=1e-3)


def strangers() -> list[Press]:
    """What neither pad knows: both things in pieces."""
    pieces = []
    for press in labelled_presses([two_pads(6)], label="thing").presses:
        pads = {name: frames.copy() for name, frames in press.pads.items()}
        for frames in pads.values():
            frames[:, 3:5] = frames[:, :, 5:7] = 0.0
        pieces.append(replace(press, pads=pads))
    return pieces


@needs_board
def test_on_an_emulated_cortex_m4f(tmp_path: Path, compiled: Path) -> None:
    known = labelled_presses([recording(["disc", "bar", "ring"] * 8, 0, (16, 16))], label="thing")
    clf = PortableClassifier().fit(known.presses, known.labels)
    counted = on_a_board(tmp_path, Export(parameters=clf.networks["pad"]), compiled)
    assert counted["other_names"] == 0
    assert counted["mean_instructions"] <= 1_000_000
    assert counted["stack_bytes"] + counted["work_bytes"] <= 48_000
    assert counted["flash_bytes"] <= 120_000


def test_another_sensor_or_shape_is_told(model: PortableClassifier) -> None:
    network = model.networks["thumb"]
    for options, message in (
        ({"shape": (16, 16)}, "shape must be the model's, 13x15, got 16x16"),
        ({"sensor": Sensor(shape=(16, 16))}, "the sensor has 16 x 16 taxels, the model was learned on 13 x 15"),
        ({"sensor": Sensor(positions_m=np.random.default_rng(0).random((9, 2)))}, "stand on no grid"),
    ):
        with pytest.raises(InputError, match=message):
            Export(parameters=network, **options)  # type: ignore[arg-type]


def test_a_pad_that_no_controller_holds_is_told() -> None:
    X = [np.pad(press.pads["thumb"], ((0, 0), (0, 0), (0, 40))) for press in KNOWN.presses]
    clf = PortableClassifier().fit(X, KNOWN.labels)
    with pytest.raises(InputError, match="a controller's pad has 4 to 48 rows and columns, got 13x55"):
        Export(parameters=clf.networks["pad_0"])


def test_any_text_is_a_name_in_c(tmp_path: Path) -> None:
    assert _text('a "cup"\\ of ??/ tea\n7') == '"a \\"cup\\"\\\\ of \\?\\?/ tea\\0127"'
    assert _text("Tasse für Öl") == '"Tasse f\\303\\274r \\303\\226l"'


@needs_compiler
def test_names_of_any_text_compile_and_are_what_they_were(tmp_path: Path, compiled_once: Path) -> None:
    odd = np.where(KNOWN.labels == "bar", 'a "b" \\ ??/ */ $x ${y} %d\\n1', "Öl½")
    clf = PortableClassifier().fit(KNOWN.presses, odd)
    wanted = Export(weights="float32", parameters=clf.networks["thumb"])
    assert built(tmp_path, wanted, SHORT) == "38 of 38 names as in Python"
    (tmp_path / "names.c").write_text(
        '#include <stdio.h>\n#include "pad.h"\nint main(void)\n{\n'
        "    for (int i = 0; i < PAD_NAMES; i++)\n        fputs(pad_names[i], stdout), putchar(0);\n    return 0;\n}\n"
    )
    others = ("main.c", "test.c", "vectors.c", "names.c")
    kernel = [path.name for path in tmp_path.glob("*.c") if path.name not in others]
    command = [*words(compiled_once, "cc"), *STRICT, "-O0", "-o", "names", "names.c", *kernel, "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    said = subprocess.run(["./names"], cwd=tmp_path, capture_output=True, check=True).stdout.decode("utf-8")
    assert said.split("\0")[:-1] == list(clf.networks["thumb"].names)


def test_the_command_takes_what_learn_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(recording(["disc", "bar"] * 12, 0), tmp_path / "learn.npz")
    write(recording(["bar", "disc"] * 4, 1), tmp_path / "new.npz")
    learn = ("learn", tmp_path / "learn.npz", "--label", "thing")
    done = told(*learn, "--portable", "-o", tmp_path / "m.npz")
    assert done.exit_code == 0, done.output
    assert "24 presses of 2 things; held out, the true thing has p = " in done.output
    lines = told("recognize", tmp_path / "m.npz", tmp_path / "new.npz").output.splitlines()
    assert [line.split()[1] for line in lines] == ["bar", "disc"] * 4
    of = ("evaluate", tmp_path / "new.npz", "--label", "thing", "--with", tmp_path / "m.npz")
    assert "100 % right by the model that was given" in told(*of).output
    quick = ("evaluate", tmp_path / "learn.npz", "--label", "thing", "--group", "day", "--no-peers", "--shots", "0")
    assert "24 presses of 2 groups" in told(*quick, "--portable").output
    out = ("touch", "export", "--to", "c", "-o", tmp_path / "fw")
    assert told(*out, "--model", tmp_path / "m.npz").exit_code == 0
    assert "bar, disc, none of these" in (tmp_path / "fw" / "README.md").read_text()
    assert "#define PAD_ROWS 13" in (tmp_path / "fw" / "pad.h").read_text()
    told(*learn, "-o", tmp_path / "large.npz")
    capsys.readouterr()
    never = ("-o", tmp_path / "never.npz")
    for arguments, message in (
        ((*out, "--model", tmp_path / "large.npz"), "is too large for a controller: learn it again with --portable"),
        ((*out, "--model", tmp_path / "new.npz"), "new.npz: is no model file"),
        ((*out, "--model", tmp_path / "m.npz", "--shape", "9x9"), "shape must be the model's, 13x15, got 9x9"),
        ((*out, "--model", tmp_path / "m.npz", "--pad", "left"), "name one of its pads, pad, got 'left'"),
        ((*out, "--pad", "left"), "only a model that learn --portable wrote has pads by name"),
        (
            (*learn, "--portable", "--position", *never),
            "--portable looks neither at places nor at loads: leave out --po",
        ),
        ((*quick, "--portable", "--absolute"), "--portable looks neither at places nor at loads: leave out --absolute"),
        ((*of, "--portable"), "portable"),
        (
            ("learn", tmp_path / "m.npz", "--add", "ring", tmp_path / "new.npz", *never),
            "takes no class more: learn all of them together",
        ),
        (("recognize", tmp_path / "m.npz", tmp_path / "new.npz", "--adapt"), "is adapted to no session"),
    ):
        assert message in failed(monkeypatch, capsys, *arguments)
    assert not (tmp_path / "never.npz").exists()
