"""In single precision an exported recognizer says of any frame what Python says, not only of clean presses."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.compiled_once import words
from tests.odd_frames import ODD_FRAMES
from tests.test_touch_export import COMPILER, STRICT, needs_compiler

from varishold.sensor import Power, Sensor, sensor_of
from varishold.touch.recognizer import decided
from varishold.touch.sensing import find_contacts
from varishold.touch.writers import Export, c99_files
from varishold.touch.writers.vectors import Vector

EACH = 20
# Names that are so nearly as likely as the likeliest may be exchanged.
TIE = 1e-3
PADS = {
    "16 x 16": Export(weights="float32"),
    "8 x 10": Export(shape=(8, 10), levels=16, contacts=4, weights="float32"),
    "glove": Export(sensor=sensor_of("stag-glove"), weights="float32"),
    "4 x 4": Export(sensor=sensor_of("xela-uspa44"), weights="float32"),
    "fingertip": Export(sensor=Sensor(shape=(5, 9), rest=120, span=880, saturation=1.0), weights="float32"),
    "falling": Export(
        sensor=Sensor(shape=(12, 10), polarity="down", rest=1023, span=1000, pitch_m=(0.002, 0.003)), weights="float32"
    ),
    "curved": Export(
        sensor=Sensor(shape=(10, 12), rest=30, span=900, response=Power(0.7), dead_band=0.02, saturation=0.98),
        weights="float32",
    ),
}
# Frames from standard input; of each what touches.
PROGRAM = """
#include <stdio.h>
#include "pad.h"
static double work[PAD_WORK_BYTES / sizeof(double) + 1];
static vh_real frame[PAD_ROWS * PAD_COLS];
int main(void)
{
    struct vh_touch touches[PAD_CONTACTS];
    while (fread(frame, sizeof frame, 1, stdin) == 1) {
        int n = vh_feel(&pad, frame, touches, work);
        printf("%d", n);
        for (int i = 0; i < n; i++)
            printf(" %d %.6f", touches[i].answer.name, (double)touches[i].answer.probability);
        printf("\\n");
    }
    return 0;
}
"""


def readings_of(wanted: Export, kind: str, i: int) -> NDArray[np.float32]:
    """Return a frame as the pad's sensor reads it, which is often in whole counts; NaN from a broken taxel."""
    rng = np.random.default_rng((1000, *wanted.rows_and_cols, list(ODD_FRAMES).index(kind), i))
    frame = ODD_FRAMES[kind](rng, wanted.rows_and_cols)
    if wanted.sensor is None:
        return np.asarray(frame * rng.choice([1, 50, 255, 10 ** rng.uniform(-3, 4)]), np.float32)
    works = ~np.isnan(frame)
    read = wanted.sensor.forward(wanted.sensor.full_scale * rng.choice([0.5, 1.0]) * np.where(works, frame, 0.0))
    read = np.round(read) if rng.random() < 0.6 else read
    return np.asarray(np.where(works, read, np.nan), np.float32)


def said_by_python(wanted: Export, readings: NDArray[np.float32]) -> list[tuple[int, float]]:
    works = ~np.isnan(readings)
    contacts = find_contacts(
        np.where(works, readings, 0.0).astype(np.float64),
        wanted.levels,
        pitch=wanted.pitch,
        sensor=wanted.sensor,
        valid=None if works.all() else works,
    )
    said = [decided(contact, wanted.decision.kernel) for contact in contacts[: wanted.contacts]]
    return [(-1, 0.0) if one is None else (one[0].name, one[0].probability) for one in said]


@needs_compiler
@pytest.mark.parametrize("pad", PADS)
def test_contacts_and_names_of_odd_frames_are_those_of_python(tmp_path: Path, compiled_once: Path, pad: str) -> None:
    wanted = PADS[pad]
    empty = Vector(np.zeros(wanted.rows_and_cols, np.float32), 0, -1, 0.0)
    for name, text in (c99_files(wanted, [empty]) | {"main.c": PROGRAM}).items():
        (tmp_path / name).write_text(text)
    sources = sorted(path.name for path in tmp_path.glob("*.c") if path.name not in ("test.c", "vectors.c"))
    command = [*words(compiled_once, str(COMPILER)), *STRICT, "-O1", "-o", "said", *sources, "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    drawn = [(kind, readings_of(wanted, kind, i)) for kind in ODD_FRAMES for i in range(EACH)]
    frames = b"".join(readings.tobytes() for _, readings in drawn)
    done = subprocess.run([tmp_path / "said"], input=frames, capture_output=True, check=True)
    lines = done.stdout.decode().splitlines()
    assert len(lines) == len(drawn)
    far = 0
    for (kind, readings), line in zip(drawn, lines, strict=True):
        n, *rest = line.split()
        names, shares = [int(name) for name in rest[::2]], [float(share) for share in rest[1::2]]
        told = said_by_python(wanted, readings)
        assert int(n) == len(told), kind
        for name, share, (own, p) in zip(names, shares, told, strict=True):
            assert name == own or abs(share - p) < TIE, (kind, line, told)
            far += abs(share - p) > TIE
    # A threshold that meets a plateau to the last bit is the last that rounding decides.
    assert far <= 0.01 * len(drawn)
