"""The recognizer as C99: it compiles under the strictest flags, and names what Python names."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.compiled_once import words

from varishold.circuit import Hyperplane, Netlist, Score, Term
from varishold.circuit.writers import WRITERS as CIRCUIT_WRITERS
from varishold.cli import main
from varishold.errors import InputError
from varishold.files import KINDS
from varishold.sensor import Logarithmic, Power, Sensor, Table
from varishold.touch import NAMES, decision, find_contacts, recognize
from varishold.touch.decision import load_parameters, read_parameters
from varishold.touch.writers import Export, c99_files, export
from varishold.touch.writers.pad import coarse
from varishold.touch.writers.vectors import SOLIDS, check_vectors

COMPILER = shutil.which("gcc") or shutil.which("cc")
BOARD = Path(__file__).parent / "cortex_m4f"
DOCS = Path(__file__).parent.parent / "docs"
ARM = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsingle-precision-constant")
FAST = ("-O2", "-funroll-loops", "-fno-math-errno", "-fno-trapping-math")
needs_compiler = pytest.mark.skipif(COMPILER is None or shutil.which("make") is None, reason="needs a C compiler, make")


def board_is_there() -> bool:
    """Tell whether programs for a Cortex-M4F can be made and run: Debian's compiler alone has no C library."""
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        return False
    asked = ["arm-none-eabi-gcc", "-print-file-name=rdimon.specs"]
    return Path(subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()).is_absolute()


needs_board = pytest.mark.skipif(
    not board_is_there(), reason="needs gcc-arm-none-eabi, libnewlib-arm-none-eabi and qemu-system-arm"
)

SENSORS = {
    "down": Sensor(polarity="down", rest=1023, span=1000, full_scale=500.0, pitch_m=(0.002, 0.003)),
    "power": Sensor(response=Power(0.7), span=4095, saturation=0.98, dead_band=0.02),
    "logarithmic": Sensor(shape=(12, 14), response=Logarithmic(20.0), rest=np.full((12, 14), 7.0), span=255),
    "table": Sensor(response=Table([0, 0.1, 0.4, 1], [0, 0.3, 0.7, 1]), span=100),
    "spread": Sensor(shape=(16, 16), span=10, crosstalk=0.05, blur_taxels=0.5),
    "gains": Sensor(
        shape=(14, 14),
        span=10,
        gains=np.where(np.arange(196).reshape(14, 14) % 61 == 30, 0.0, 1.1),
        field=np.add.outer(np.arange(14), np.arange(14)) > 2,
    ),
}


# What stands in the Makefile is tried once a kind; this compiles in a third of the time.
SHORT = "CFLAGS=-O0"


def built(folder: Path, wanted: Export, *said: str) -> str:
    """Export, compile by its own Makefile, and return what its test prints."""
    export(wanted, "c", folder)
    done = subprocess.run(["make", "-s", "test", *said], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()[-1]


@needs_compiler
@pytest.mark.parametrize("shape", [(16, 16), (5, 6)])
def test_a_frame_at_its_end_everywhere_is_as_unsure_as_in_python(
    tmp_path: Path, shape: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("varishold.touch.writers.vectors._drawn", lambda _, rng, *of: np.full(shape, of[-1]))
    wanted = Export(shape=shape, weights="float32")
    assert [vector.name for vector in check_vectors(wanted, 3)] == [*2 * [NAMES.index("plane")], -1]
    assert all(vector.probability == pytest.approx(0.85, abs=1e-3) for vector in check_vectors(wanted, 3)[:2])
    assert built(tmp_path, wanted, SHORT) == "65 of 65 names as in Python"


@needs_compiler
@pytest.mark.parametrize("shape", [(4, 6), (6, 8)])
def test_two_names_that_are_as_likely_with_coarse_weights_fail_no_test(tmp_path: Path, shape: tuple[int, int]) -> None:
    assert re.fullmatch(r"6[345] of 65 names as in Python", built(tmp_path, Export(shape=shape), SHORT))


@needs_compiler
@pytest.mark.usefixtures("compiled_once")
@pytest.mark.parametrize("sensor", SENSORS)
def test_with_a_sensor_built_in_names_are_those_of_python(tmp_path: Path, sensor: str) -> None:
    said = () if sensor == "gains" else (SHORT,)
    assert built(tmp_path, Export(sensor=SENSORS[sensor], weights="float32"), *said) == "65 of 65 names as in Python"


@needs_compiler
@pytest.mark.usefixtures("compiled_once")
@pytest.mark.parametrize(("shape", "levels"), [((8, 9), 16), ((24, 20), 64)])
def test_pads_of_other_sizes_have_names_as_in_python(tmp_path: Path, shape: tuple[int, int], levels: int) -> None:
    wanted = Export(shape=shape, levels=levels, weights="float32")
    assert built(tmp_path, wanted, *(() if levels == 16 else (SHORT,))) == "65 of 65 names as in Python"


@needs_compiler
@pytest.mark.usefixtures("compiled_once")
def test_a_compiler_without_single_precision_constants_gives_the_same_names(tmp_path: Path) -> None:
    assert built(tmp_path, Export(weights="float32"), "SINGLE=", SHORT) == "65 of 65 names as in Python"


@needs_compiler
def test_with_coarse_weights_hardly_a_name_is_another(tmp_path: Path) -> None:
    # By the compiler that the Makefile itself takes, all sources at once.
    same = int(built(tmp_path, Export()).split()[0])
    assert same >= 64
    example = subprocess.run(["make", "-s", "all", SHORT], cwd=tmp_path, check=False)
    assert example.returncode == 0
    told = subprocess.run(["./example"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert told.splitlines()[-1].split(" (")[0] in ("sphere", "cone", "unknown")
    assert "malloc" not in subprocess.run(["nm", "check"], cwd=tmp_path, capture_output=True, text=True).stdout


def on_a_board(folder: Path, wanted: Export, compiled: Path) -> dict[str, int]:
    """Export, compile for a Cortex-M4F and run there: what is counted, and the flash that it takes in bytes."""
    export(wanted, "c", folder)
    sources = [path.name for path in folder.glob("*.c") if path.name not in ("main.c", "test.c")]
    compiler = words(compiled, "arm-none-eabi-gcc")
    subprocess.run([*compiler, *ARM, *STRICT, *FAST, "-c", *sources], cwd=folder, check=True)
    objects = [name.removesuffix(".c") + ".o" for name in sources]
    board = [str(BOARD / name) for name in ("start.c", "count.c")]
    link = ["-T", str(BOARD / "link.ld"), "--specs=rdimon.specs", "-nostartfiles", "-lm", "-o", "count.elf"]
    command = ["arm-none-eabi-gcc", *ARM, "-O2", "-I.", *board, *objects, *link]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    emulator = ["qemu-system-arm", "-M", "mps2-an386", "-nographic", "-icount", "shift=0", "-kernel", "count.elf"]
    told = subprocess.run(
        [*emulator, "-semihosting-config", "enable=on,target=native"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    counted: dict[str, int] = json.loads(told.stdout)
    sizes = subprocess.run(
        ["arm-none-eabi-size", *(name for name in objects if name != "vectors.o")],
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()[1:]
    counted["flash_bytes"] = sum(int(line.split()[0]) for line in sizes)
    print(f"\n{counted}")
    return counted


@needs_board
def test_on_an_emulated_cortex_m4f(tmp_path: Path, compiled: Path) -> None:
    counted = on_a_board(tmp_path, Export(), compiled)
    assert counted["other_names"] <= 1
    assert counted["mean_instructions"] <= 1_000_000
    assert counted["stack_bytes"] + counted["work_bytes"] <= 48_000
    assert counted["flash_bytes"] <= 200_000


def test_whole_weights_are_at_most_half_a_step_off() -> None:
    weight = np.random.default_rng(0).normal(size=(30, 7)).astype(np.float32)
    weight[:, 3] = 0.0
    whole, scale = coarse(weight)
    assert np.all(np.abs(whole * scale - weight) <= scale / 2 + 1e-6)


def test_half_as_many_thresholds_name_drawn_frames_as_well_and_four_do_not() -> None:
    named = {"cone-frustum": "frustum of a cone", "pyramid-frustum": "frustum of a pyramid"}
    truth = [named.get(solid, solid.replace("-", " ")) for solid in SOLIDS] * 10
    right, surely_wrong = {}, {}
    for levels in (4, 16, 32):
        said = check_vectors(Export(levels=levels), len(truth) + 1)[:-1]
        pairs = [(NAMES[vector.name] == name, vector.probability) for vector, name in zip(said, truth, strict=True)]
        right[levels] = np.mean([same for same, _ in pairs])
        surely_wrong[levels] = np.mean([not same and p > 0.9 for same, p in pairs])
    assert right[4] < 0.85 < 0.98 < min(right[16], right[32])
    assert surely_wrong[4] > 0.02 > max(surely_wrong[16], surely_wrong[32])


def test_the_same_export_is_the_same_text() -> None:
    assert c99_files(Export(shape=(9, 8))) == c99_files(Export(shape=(9, 8)))


def test_vectors_are_of_every_kind_and_one_is_empty() -> None:
    vectors = check_vectors(Export(), 27)
    assert vectors[-1].name == -1
    assert not vectors[-1].readings.any()
    assert len({vector.name for vector in vectors}) > 8


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"shape": (3, 16)}, "has 4 to 48 rows and columns, got 3x16"),
        ({"shape": (16, 49)}, "has 4 to 48 rows and columns, got 16x49"),
        ({"levels": 3}, "levels must be from 4 to 512, got 3"),
        ({"contacts": 0}, "contacts must be from 1 to 64, got 0"),
        ({"sensor": SENSORS["logarithmic"], "shape": (16, 16)}, "shape must be the sensor's, 12x14, got 16x16"),
        ({"parameters": load_parameters("reliefs")}, "has the 173 inputs of the signature, got 519"),
        ({"sensor": Sensor(span=1e39)}, r"span of .* that is exported must be at most 1e\+17, .* got 1e\+39"),
        ({"sensor": Sensor(rest=np.full((16, 16), -1e20))}, "rest of a sensor that is exported must be at most"),
        ({"sensor": Sensor(span=1.0, full_scale=1e30)}, "full_scale of a sensor that is exported must be at most"),
        ({"sensor": Sensor(positions_m=np.random.default_rng(0).random((9, 2)))}, "stand on no grid"),
        (
            {"sensor": Sensor(shape=(5, 5), crosstalk=0.1, field=np.arange(25).reshape(5, 5) > 0)},
            "crosstalk and blur of a pad with gaps",
        ),
    ],
)
def test_what_cannot_be_exported_is_told(options: dict[str, object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        Export(**options)  # type: ignore[arg-type]


def test_a_table_from_a_file_can_be_exported_and_another_file_is_refused(tmp_path: Path) -> None:
    shipped = Path(decision.__file__).parent / "parameters" / "early.npz"
    files = c99_files(Export(parameters=read_parameters(shipped)))
    assert "layers[]" in files["pad.c"]
    np.savez(tmp_path / "other.npz", pressure=np.zeros((1, 2, 2)))
    with pytest.raises(InputError, match="is no table of parameters"):
        read_parameters(tmp_path / "other.npz")


def test_the_command_writes_a_folder_and_leaves_foreign_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "pad"

    def export_it(*words: str) -> int:
        monkeypatch.setattr(sys, "argv", ["varishold", "touch", "export", "--to", "c", "-o", str(folder), *words])
        with pytest.raises(SystemExit) as left:
            main()
        return int(left.value.code or 0)

    assert export_it("--shape", "9x8") == 0
    told = f"{folder}: {len(list(folder.iterdir()))} files; README.md says what each is and how to build them\n"
    assert capsys.readouterr().out == told
    assert "#define PAD_ROWS 9" in (folder / "pad.h").read_text()
    (folder / "main.c").write_text("int main(void) { return 0; }\n")
    assert export_it() == 1
    assert "main.c: is there, and is no exported source" in capsys.readouterr().err
    assert "#define PAD_ROWS 9" in (folder / "pad.h").read_text()
    assert export_it("--force") == 0
    assert "#define PAD_ROWS 16" in (folder / "pad.h").read_text()


def test_a_recognizer_and_a_circuit_take_no_place_of_each_other(tmp_path: Path) -> None:
    circuit = Netlist(
        ("a",), (), (Hyperplane([(0, 1)], 0),), (Term([(0, 1)]),), (Score([], 0), Score([(0, 1)])), ("x", "y")
    )
    files = {
        "source": c99_files(Export(shape=(9, 8)), check_vectors(Export(shape=(9, 8)), 2)),
        "circuit": {k: v for write in CIRCUIT_WRITERS.values() for k, v in write(circuit, "pad").items()},
    }
    for kind, texts in files.items():
        for name, text in texts.items():
            (tmp_path / name).write_text(text)
            assert {other for other in files if KINDS[other].recognizes(tmp_path / name)} == {kind}, name


@pytest.mark.parametrize("weights", ["float32", "int8"])
def test_the_size_that_is_told_is_that_of_the_tables(weights: str) -> None:
    files = c99_files(Export(shape=(9, 8), weights=weights), check_vectors(Export(shape=(9, 8)), 3))
    each = {"float": 4, "vh_real": 4, "int8_t": 1}
    tables = re.findall(r"static const (\w+) (\w+)\[\] = \{(.*?)\};", files["pad.c"], re.S)
    counted = sum(each[kind] * values.count(",") for kind, _, values in tables if kind in each)
    told = re.search(r"tables \(flash\) \| (\d+) bytes", files["README.md"])
    assert told is not None
    assert int(told[1]) == counted


def test_the_stack_that_is_told_is_that_of_the_docs() -> None:
    told = re.search(r"\| stack \| some (\d) kB", c99_files(Export(), check_vectors(Export(), 2))["README.md"])
    measured = re.search(r"work space and stack \| .* kB and ([\d.]+) kB", (DOCS / "microcontroller.md").read_text())
    assert told is not None
    assert measured is not None
    assert int(told[1]) == round(float(measured[1]))


# Each vector with three taxels unread, then what no sensor reads.
ODD = """
#include <math.h>
#include <stdio.h>
#include "vectors.h"
static double work[PAD_WORK_BYTES / sizeof(double) + 1];
static vh_real frame[PAD_ROWS * PAD_COLS];
int main(void)
{
    struct vh_touch touches[PAD_CONTACTS];
    const vh_real strange[] = {INFINITY, -INFINITY, 3e38f, -3e38f};
    for (int k = 0; k < vectors_count + 5; k++) {
        for (int i = 0; i < PAD_ROWS * PAD_COLS; i++)
            frame[i] = k <= vectors_count ? vectors_readings(k % vectors_count)[i] : 0;
        for (int i = 0; i < 3 && k < vectors_count; i++)
            frame[(PAD_ROWS / 2 + i - 1) * PAD_COLS + PAD_COLS / 2 - i] = NAN;
        for (int i = 0; i < PAD_ROWS * PAD_COLS && k == vectors_count; i++)
            frame[i] = NAN;
        if (k > vectors_count)
            frame[PAD_COLS + 1] = strange[k - vectors_count - 1];
        int n = vh_feel(&pad, frame, touches, work);
        int name = n > 0 ? touches[0].answer.name : -1;
        printf("%d %d %.6f\\n", n, name, n > 0 ? (double)touches[0].answer.probability : 0);
    }
    return 0;
}
"""


@needs_compiler
@pytest.mark.parametrize("sensor", [None, SENSORS["down"], SENSORS["spread"]], ids=["none", "down", "spread"])
def test_what_is_not_read_is_filled_as_a_broken_taxel_and_what_no_sensor_reads_is_refused(
    tmp_path: Path, sensor: Sensor | None
) -> None:
    wanted = Export(shape=(16, 16), sensor=sensor, weights="float32")
    files = c99_files(wanted)
    vectors = check_vectors(wanted)
    for name, text in (files | {"test.c": ODD}).items():
        (tmp_path / name).write_text(text)
    assert subprocess.run(["make", "-s", "check", SHORT], cwd=tmp_path, check=False).returncode == 0
    told = subprocess.run(["./check"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line.split()[0] for line in told[-5:]] == ["-1"] * 5
    valid = np.ones((16, 16), bool)
    valid[[7, 8, 9], [8, 7, 6]] = False
    for vector, line in zip(vectors, told, strict=False):
        n, name, probability = line.split()
        contacts = find_contacts(vector.readings.astype(np.float64), pitch=wanted.pitch, valid=valid, sensor=sensor)
        assert int(n) == min(len(contacts), wanted.contacts)
        if contacts:
            surface = recognize(contacts[0])
            assert NAMES[int(name)] == surface.name
            assert float(probability) == pytest.approx(surface.probability, abs=0.02)


def test_names_of_a_pad_are_those_of_c_in_cplusplus_too() -> None:
    text = c99_files(Export(shape=(8, 8)))["pad.h"]
    begin, end = text.index('extern "C" {'), text.index("#ifdef __cplusplus\n}")
    assert begin < text.index("extern const struct vh_pad pad;") < text.index("pad_names[") < end


def test_an_empty_pad_has_neither_a_name_nor_a_probability() -> None:
    last = check_vectors(Export(shape=(9, 8)), 2)[-1]
    assert (last.n_touches, last.name, last.probability) == (0, -1, 0.0)
