"""Generated source: numpy = packed = C = Verilog on every vector, clean builds, and names from outside."""

from __future__ import annotations

import re
import resource
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_circuit_netlist import netlists

from varishold.circuit import (
    Comparator,
    Hyperplane,
    Netlist,
    PackedEvaluator,
    Score,
    Term,
    evaluate,
    netlist_from_json,
)
from varishold.circuit.writers import WRITERS, c99_files, export, verilog_files
from varishold.circuit.writers.c99 import compiled_size
from varishold.circuit.writers.names import c_string, comment, comments, identifier, taken_by
from varishold.circuit.writers.vectors import check_vectors
from varishold.errors import InputError

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
needs_iverilog = pytest.mark.skipif(shutil.which("iverilog") is None, reason="iverilog is not installed")
needs_yosys = pytest.mark.skipif(shutil.which("yosys") is None, reason="yosys is not installed")

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wshadow"]


def random_netlist(
    seed: int, channels: int, *, units: int = 6, terms: int = 5, classes: int = 3, counts: bool = False
) -> Netlist:
    rng = np.random.default_rng(seed)
    comparators = [Comparator(int(rng.integers(channels)), int(rng.integers(-3000, 3000))) for _ in range(2 * channels)]
    bits = len(comparators) if counts else channels

    def sparse(size: int, entries: int, largest: int) -> list[tuple[int, int]]:
        indices = rng.choice(size, min(size, entries), replace=False)
        weights = rng.integers(1, largest + 1, len(indices)) * rng.choice([-1, 1], len(indices))
        return list(zip(indices.tolist(), weights.tolist(), strict=True))

    return Netlist(
        channels=tuple(f"switch {k}" for k in range(channels)),
        comparators=tuple(comparators) if counts else (),
        units=tuple(
            Hyperplane(sparse(bits, int(rng.integers(1, 12)), 1 + 2 * (k % 2)), int(rng.integers(-3, 3)))
            for k in range(units)
        ),
        terms=tuple(
            Term([(u, int(rng.integers(2))) for u, _ in sparse(units, int(rng.integers(1, 4)), 1)])
            for _ in range(terms)
        ),
        scores=tuple(Score(sparse(terms, 3, 4), int(rng.integers(-2, 3))) for _ in range(classes)),
        classes=tuple(f"class {k}" for k in range(classes)),
    )


CASES = [
    pytest.param(random_netlist(0, 1, classes=2), id="one switch"),
    pytest.param(random_netlist(1, 10), id="ten switches"),
    pytest.param(random_netlist(2, 16, units=12, terms=8, classes=2), id="sixteen switches"),
    pytest.param(random_netlist(3, 14, units=12, terms=9, classes=6), id="six classes"),
    pytest.param(random_netlist(4, 8, classes=1), id="one class"),
    pytest.param(random_netlist(5, 8, units=0, terms=0, classes=3), id="biases alone"),
    pytest.param(random_netlist(6, 40, units=12, terms=8), id="forty switches"),
    pytest.param(random_netlist(7, 300, units=9, terms=9, classes=5), id="three hundred switches"),
    pytest.param(random_netlist(8, 6, counts=True), id="counts"),
    pytest.param(
        Netlist(
            ("low", "high"),
            (Comparator(0, -(2**31) + 1), Comparator(1, 2**31 - 1), Comparator(0, 0)),
            (Hyperplane([(0, 2**28), (1, -(2**28)), (2, 1)], 2**28 - 1),),
            (Term([(0, 1)]), Term([])),
            (Score([(1, -(2**28))], 0), Score([(0, 2**29)], 1 - 2**29)),
            ("a", "b"),
        ),
        id="extreme numbers",
    ),
]


def _write(files: dict[str, str], folder: Path) -> None:
    for file, text in files.items():
        (folder / file).write_text(text, encoding="utf-8")


def _run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def in_c(netlist: Netlist, X: np.ndarray, folder: Path) -> np.ndarray:
    """Compile the C source and run it over rows of int32 from standard input."""
    _write(c99_files(netlist, "hand", vectors=64), folder)
    kind = "int32_t" if netlist.comparators else "uint8_t"
    (folder / "filter.c").write_text(
        f"""
        #include <stdio.h>
        #include "hand.h"
        int main(void) {{
            {kind} row[HAND_CHANNELS];
            while (fread(row, sizeof row[0], HAND_CHANNELS, stdin) == HAND_CHANNELS) {{
                unsigned long k = hand_classify(row);
                printf("%lu\\n", k);
            }}
            return 0;
        }}
        """
    )
    _run(["gcc", *STRICT, "-O1", "hand.c", "hand_test.c", "-o", "selftest"], folder)
    assert _run(["./selftest"], folder).startswith("PASS")
    _run(["gcc", *STRICT, "-O1", "-fsanitize=undefined,address", "hand.c", "filter.c", "-o", "filter"], folder)
    rows = np.ascontiguousarray(X, np.int32 if netlist.comparators else np.uint8)
    done = subprocess.run(["./filter"], cwd=folder, input=rows.tobytes(), capture_output=True, check=True)
    return np.array(done.stdout.split(), int)


def in_verilog(netlist: Netlist, folder: Path, vectors: int) -> str:
    """Run the self-checking bench; its vectors carry the answers of the reference evaluator."""
    _write(verilog_files(netlist, "hand", vectors=vectors), folder)
    _run(["iverilog", "-g2001", "-Wall", "-Wno-timescale", "-o", "bench", "hand.v", "hand_tb.v"], folder)
    return _run(["vvp", "-n", "bench"], folder)


@pytest.mark.parametrize("netlist", CASES)
def test_packed_agrees_with_numpy_on_every_vector(netlist: Netlist) -> None:
    X = check_vectors(netlist, 2**16)
    np.testing.assert_array_equal(PackedEvaluator(netlist).evaluate(X), evaluate(netlist, X))


@needs_gcc
@pytest.mark.parametrize("netlist", CASES)
def test_c_agrees_with_numpy_on_every_vector(netlist: Netlist, tmp_path: Path) -> None:
    X = check_vectors(netlist, 2**16)
    np.testing.assert_array_equal(in_c(netlist, X, tmp_path), evaluate(netlist, X))


@needs_iverilog
@pytest.mark.parametrize("netlist", CASES)
def test_verilog_agrees_with_numpy_on_every_vector(netlist: Netlist, tmp_path: Path) -> None:
    most = 2**16 if len(netlist.channels) <= 16 and not netlist.comparators else 2**12
    X = check_vectors(netlist, most)
    assert in_verilog(netlist, tmp_path, most).splitlines()[-1] == f"PASS {len(X)}"


@needs_gcc
@settings(max_examples=6)
@given(netlists(max_channels=8))
def test_c_agrees_on_any_netlist(netlist: Netlist) -> None:
    X = check_vectors(netlist, 2**8)
    with tempfile.TemporaryDirectory() as folder:
        np.testing.assert_array_equal(in_c(netlist, X, Path(folder)), evaluate(netlist, X))


@needs_iverilog
@settings(max_examples=10)
@given(netlists(max_channels=8))
def test_verilog_agrees_on_any_netlist(netlist: Netlist) -> None:
    X = check_vectors(netlist, 2**8)
    with tempfile.TemporaryDirectory() as folder:
        assert in_verilog(netlist, Path(folder), 2**8).splitlines()[-1] == f"PASS {len(X)}"


@needs_iverilog
def test_the_bench_of_a_large_circuit_ends_soon(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    units = tuple(
        Hyperplane([(int(bit), int(rng.choice([-1, 1]))) for bit in rng.choice(22, 7, replace=False)], 0)
        for _ in range(400)
    )
    votes = tuple(Score([(unit, int(rng.integers(1, 30))) for unit in range(k, 400, 2)], 0) for k in range(2))
    channels, terms = tuple(f"x{k}" for k in range(22)), tuple(Term([(unit, 1)]) for unit in range(400))
    netlist = Netlist(channels, (), units, terms, votes, ("a", "b"))
    begun = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    assert "PASS 1024" in in_verilog(netlist, tmp_path, 1024)
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - begun < 8


@needs_iverilog
def test_the_bench_can_fail(tmp_path: Path) -> None:
    netlist = random_netlist(1, 10)
    files = verilog_files(netlist, "hand")
    lines = files["hand_vectors.hex"].splitlines()
    lines[5] = f"{int(lines[5], 16) ^ 1 << 10:0{len(lines[5])}x}"
    _write({**files, "hand_vectors.hex": "\n".join(lines)}, tmp_path)
    _run(["iverilog", "-g2001", "-o", "bench", "hand.v", "hand_tb.v"], tmp_path)
    # wrong in the combinational module and in the registered one
    assert "FAIL 2 wrong" in _run(["vvp", "-n", "bench"], tmp_path)


HOSTILE = [
    'quote" ); system("rm -rf /"); //',
    "*/ #error injected /*",
    'line\n#error injected\r\n`include "x"',
    "trigraph ??/ ??'",
    "back\\",
    "手の平 🖐",
    "module",
    "int",
    "`define X",
    "%s%n",
    "tab\t\x00nul",
    "endmodule",
]


@needs_gcc
def test_hostile_names_stay_names_in_c(tmp_path: Path) -> None:
    netlist = Netlist(
        channels=tuple(HOSTILE),
        comparators=(),
        units=tuple(Hyperplane([(k, 1)], 0) for k in range(len(HOSTILE))),
        terms=tuple(Term([(k, 1)]) for k in range(len(HOSTILE))),
        scores=tuple(Score([(k, 1)]) for k in range(len(HOSTILE))),
        classes=tuple(HOSTILE),
    )
    _write(c99_files(netlist, HOSTILE[0]), tmp_path)
    name = identifier(HOSTILE[0])
    (tmp_path / "labels.c").write_text(
        f"""
        #include <stdio.h>
        #include "{name}.h"
        int main(void) {{
            for (int k = 0; k < {name.upper()}_CLASSES; k++) {{
                fputs({name}_labels[k], stdout);
                putchar(1);
            }}
            return 0;
        }}
        """
    )
    _run(["gcc", *STRICT, f"{name}.c", "labels.c", "-o", "labels"], tmp_path)
    done = subprocess.run(["./labels"], cwd=tmp_path, capture_output=True, check=True)
    expected = [label.split("\0")[0].encode() for label in HOSTILE]  # C ends a string at its first nul
    assert done.stdout.split(b"\x01")[:-1] == expected


def test_whole_numbers_of_numpy_are_whole_numbers() -> None:
    netlist = random_netlist(8, 6, counts=True)
    plain = verilog_files(netlist, vectors=9, count_bits=20)
    assert verilog_files(netlist, vectors=np.int64(9), count_bits=np.uint8(20)) == plain  # type: ignore[arg-type]


@needs_gcc
@pytest.mark.parametrize("name", ["stdint", "STDIO.H", "string", "features", "math", "int", "main", "static_cast"])
def test_no_source_is_called_as_a_header_of_the_system(tmp_path: Path, name: str) -> None:
    files = c99_files(random_netlist(0, 1, classes=2), name.removesuffix(".H"))
    _write(files, tmp_path)
    called = f"m_{name.removesuffix('.H').lower()}"
    assert set(files) == {f"{called}.h", f"{called}.c", f"{called}_test.c"}
    assert taken_by(called, header=True) == ""
    includes = "".join(f"#include <{each}.h>\n" for each in ("stdint", "stdio", "string", "math"))
    (tmp_path / "user.c").write_text(f'{includes}#include "{called}.h"\n')
    _run(["gcc", *STRICT, "-I.", "-c", "user.c"], tmp_path)
    _run(["gcc", *STRICT, "-I.", f"{called}.c", f"{called}_test.c", "-o", "check"], tmp_path)
    _run(["./check"], tmp_path)


@needs_iverilog
def test_hostile_names_stay_names_in_verilog(tmp_path: Path) -> None:
    netlist = Netlist(
        channels=tuple(HOSTILE),
        comparators=(),
        units=(Hyperplane([(0, 1), (3, -1)], 0),),
        terms=(Term([(0, 1)]),),
        scores=tuple(Score([(0, k)] if k else []) for k in range(len(HOSTILE))),
        classes=tuple(HOSTILE),
    )
    for k, name in enumerate(["module", "logic", "Program", "2", "a;b", "手"]):
        folder = tmp_path / str(k)
        folder.mkdir()
        files = verilog_files(netlist, name, vectors=64)
        _write(files, folder)
        sources = [file for file in files if file.endswith(".v")]
        for language in ("-g2001", "-g2012"):
            _run(["iverilog", language, "-o", "bench", *sources], folder)
            assert _run(["vvp", "-n", "bench"], folder) == "PASS 64\n"


@pytest.mark.parametrize("writer", [c99_files, verilog_files])
@pytest.mark.parametrize("ending", ["test", "tb", "registered"])
def test_two_circuits_in_one_folder_leave_each_other_whole(writer: Callable[..., dict[str, str]], ending: str) -> None:
    netlist = random_netlist(0, 3)
    one, other = writer(netlist, "hand"), writer(netlist, f"hand_{ending}")
    assert not one.keys() & other.keys()
    assert not {f"module hand_{ending} (", f"module hand_{ending};"} & {*"\n".join(other.values()).splitlines()}


@given(st.text(max_size=30))
def test_no_name_can_leave_its_place(text: str) -> None:
    assert identifier(text).isidentifier()
    assert identifier(text).isascii()
    literal = c_string(text)
    assert literal.isascii()
    assert not set(literal[1:-1]) & set('"\n\r?')
    assert comment(text).isprintable()
    assert not set(comment(text)) & set('*/\\`"?\n')


@given(st.lists(st.text(alphabet="ab_/<>2FU+;é", max_size=9), max_size=6, unique=True))
def test_comments_of_different_names_differ(names: list[str]) -> None:
    told = comments(names)
    assert len(set(told)) == len(names)
    assert [comment(text) for text in told] == told


def test_channels_and_classes_that_are_spelt_alike_are_told_apart() -> None:
    netlist = Netlist(
        channels=("a/b", "a_b"),
        comparators=(),
        units=(Hyperplane([(0, 1), (1, -1)], 0),),
        terms=(Term([(0, 1)]),),
        scores=(Score([], 1), Score([(0, 2)])),
        classes=("Bär", "Bör"),
    )
    source = verilog_files(netlist)["recognizer.v"]
    for line in ("switches[0]: a<U+2F>b", "switches[1]: a_b", "class 0: B<U+E4>r", "class 1: B<U+F6>r"):
        assert f"// {line}\n" in source
    assert "/* 0: a<U+2F>b */\n/* 1: a_b */\n" in c99_files(netlist)["recognizer.h"]


@pytest.mark.parametrize("netlist", CASES)
def test_no_float_and_no_allocation_in_c(netlist: Netlist) -> None:
    source = c99_files(netlist)["recognizer.c"]
    code = re.sub(r"/\*.*?\*/|\"[^\"]*\"", "", source, flags=re.DOTALL)
    for word in ("float", "double", "alloc", "."):
        assert word not in code.replace("recognizer.h", "")


@pytest.mark.parametrize("to", list(WRITERS))
def test_export_writes_the_same_bytes_twice(to: str, tmp_path: Path) -> None:
    netlist = random_netlist(1, 10)
    first = export(netlist, to, tmp_path / "new" / "one", name="My Hand")
    second = export(netlist, to, tmp_path / "two", name="My Hand")
    assert [path.name for path in first] == [path.name for path in second]
    assert all(path.name.startswith("my_hand") for path in first)
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_exported_json_is_the_netlist(tmp_path: Path) -> None:
    netlist = random_netlist(1, 10)
    (path,) = export(netlist, "json", tmp_path)
    assert netlist_from_json(path.read_text()) == netlist


def test_export_says_what_it_cannot_do(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no writer called 'vhdl'; known are c, verilog, json"):
        export(random_netlist(1, 3), "vhdl", tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be made a folder: it is a file; name a folder"):
        export(random_netlist(1, 3), "c", tmp_path / "file")
    with pytest.raises(InputError, match="does not fit 8 signed bits; raise count_bits"):
        verilog_files(random_netlist(8, 6, counts=True), count_bits=8)


@needs_gcc
def test_the_size_is_reported() -> None:
    size = compiled_size(random_netlist(2, 16, units=12, terms=8, classes=2))
    assert size is not None
    assert 200 < size["text"] < 4000
    assert size["bss"] == 0
    assert compiled_size(random_netlist(2, 4), compiler="no-such-compiler") is None


@needs_yosys
def test_yosys_proves_the_two_modules_synthesizable(tmp_path: Path) -> None:
    _write(verilog_files(random_netlist(1, 10), "hand"), tmp_path)
    script = "read_verilog hand.v; synth -top hand_registered; check -assert; stat"
    assert "Number of cells" in _run(["yosys", "-p", script], tmp_path)
