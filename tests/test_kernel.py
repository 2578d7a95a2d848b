"""The compiled kernel: how it is found and called, and what is said where it is not."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import MissingKernelError
from varishold.frame import frame_noise
from varishold.kernel import address, bind, work_space
from varishold.kernel import library as binding


def test_an_address_is_where_the_numbers_are() -> None:
    array = np.arange(6.0)
    assert (ctypes.c_double * 6).from_address(address(array))[:] == array.tolist()
    assert address(array[2:]) == address(array) + 16
    array.flags.writeable = False
    with pytest.raises(TypeError):
        address(array)


@given(st.lists(st.integers(1, 1 << 20), min_size=1, max_size=5))
def test_a_work_space_is_as_large_as_asked_and_begins_at_a_cache_line(sizes: list[int]) -> None:
    for n_bytes in sizes:
        at = work_space(n_bytes)
        assert at % 64 == 0
        ctypes.memset(at, 1, n_bytes)


def test_a_work_space_that_was_large_is_given_back() -> None:
    ctypes.memset(work_space(1 << 26), 1, 1 << 26)
    ctypes.memset(work_space(100), 1, 100)


def test_the_noise_of_the_kernel_is_that_of_a_frame() -> None:
    sigma, room = bind("vh_noise_sigma", "ppiip", "d"), bind("vh_noise_sigma_work", "ii", "z")
    rng = np.random.default_rng(0)
    for _ in range(40):
        frame = rng.normal(size=rng.integers(1, 40, 2))
        frame[frame < rng.choice([-np.inf, 0, 1])] = 0.0
        usable = rng.random(frame.shape) > rng.choice([-1.0, 0.1])
        found = sigma(address(frame), address(usable), *frame.shape, work_space(room(*frame.shape)))
        assert found == pytest.approx(frame_noise(frame, valid=usable), rel=1e-9)


class _Frame(ctypes.Structure):
    """struct vh_frame of varishold.h."""

    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("frame", "field", "valid", "thresholds")),
        *((name, ctypes.c_double) for name in ("row_pitch", "col_pitch", "floor", "timed_sigma")),
        *((name, ctypes.c_int32) for name in ("rows", "cols", "n_levels", "reserved")),
        *((name, ctypes.c_void_p) for name in ("padded", "label", "dead", "work")),
        *((name, ctypes.c_void_p) for name in ("places", "values", "measures", "counts", "order")),
        *((name, ctypes.c_double) for name in ("sigma", "reach", "rest_0", "rest_1", "rest_2")),
        *((name, ctypes.c_int32) for name in ("n_contacts", "n_ordered", "n_events", "has_gaps")),
    ]


@pytest.mark.parametrize("given", [True, False])
def test_no_threshold_at_all_measures_nothing_and_reads_none(given: bool) -> None:
    room, find = bind("vh_contacts_work", "iii", "z"), bind("vh_find_contacts", "p", "i")
    measure = bind("vh_measure_contacts", "p", "")
    frame, thresholds = np.zeros((5, 6)), np.full(3, np.nan)
    frame[2:4, 2:4] = 1.0
    padded, label, dead = np.empty(56), np.empty(56, np.int32), np.empty(30, np.uint8)
    places, values, order = np.empty(9, np.int64), np.empty(2), np.empty(1, np.int32)
    measures, counts = np.full(1, -7.0), np.full(1, -7, np.int64)
    # What a work space held before is no threshold either.
    work = np.full(room(5, 6, 0) // 8 + 1, np.nan)
    task = _Frame(address(frame), None, None, address(thresholds) + 8 if given else None, 1, 1, 0.1, -1, 5, 6, 0, 0)
    task.padded, task.label, task.dead, task.work = map(address, (padded, label, dead, work))
    task.places, task.values, task.measures, task.counts, task.order = map(
        address, (places, values, measures, counts, order)
    )
    assert find(ctypes.addressof(task)) == 0
    assert task.n_contacts == 1
    measure(ctypes.addressof(task))
    assert (measures[0], counts[0]) == (-7.0, -7)


def test_both_libraries_give_the_same_bits() -> None:
    """What was compiled for wider registers computes in the same order."""
    if not Path(binding.library()._name).name.startswith("varishold_avx"):
        pytest.skip("this processor has the baseline only, or another library was chosen")
    rng = np.random.default_rng(3)
    frame = rng.normal(size=(37, 41))
    usable = rng.random(frame.shape) > 0.1
    work = np.empty(2 * frame.size)
    found = set()
    for library in (binding.library(), binding._load("baseline")):
        sigma = library.vh_noise_sigma
        sigma.argtypes, sigma.restype = [ctypes.c_void_p] * 2 + [ctypes.c_int] * 2 + [ctypes.c_void_p], ctypes.c_double
        found.add(sigma(address(frame), address(usable), *frame.shape, address(work)))
    assert len(found) == 1


def test_a_missing_kernel_is_told_in_one_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(binding, "__file__", str(tmp_path / "library.py"))
    with pytest.raises(MissingKernelError, match=r"is missing; .* python native/build.py$"):
        binding._load("baseline")
    (tmp_path / f"varishold_baseline{binding._SUFFIX}").write_bytes(b"no library")
    with pytest.raises(MissingKernelError, match=r"cannot be loaded \(.*\); .* python native/build.py$"):
        binding._load("baseline")


def test_another_kernel_can_be_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("VARISHOLD_KERNEL", str(tmp_path / "mine.so"))
    with pytest.raises(MissingKernelError, match=r"mine\.so is missing"):
        binding.library.__wrapped__()


def test_an_old_kernel_is_told_in_one_line() -> None:
    with pytest.raises(MissingKernelError, match=r"no function vh_of_tomorrow: it is older than the package"):
        bind("vh_of_tomorrow", "p")


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_sources_are_plain_c99(tmp_path: Path) -> None:
    for source in sorted((Path(__file__).parents[1] / "native").glob("*.c")):
        strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-c"]
        done = subprocess.run(
            ["cc", *strict, source, "-o", tmp_path / "x.o"], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr


def test_a_kernel_is_compiled_once() -> None:
    build = Path(__file__).parents[1] / "native" / "build.py"
    library = Path(binding.__file__).with_name(f"varishold_baseline{binding._SUFFIX}")
    before = library.stat().st_mtime_ns
    subprocess.run([sys.executable, str(build)], check=True)
    assert library.stat().st_mtime_ns == before
