"""What Rerun's own program says of our MCAP files: ``pip install rerun-sdk`` in an environment on the PATH."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mcap", reason="MCAP needs the extra live")
pytest.importorskip("rosbags", reason="MCAP needs the extra live")

from varishold.recording import Mark, Pad, Recording, Signals, write

RERUN = shutil.which("rerun")
pytestmark = pytest.mark.skipif(RERUN is None, reason="there is no Rerun here")


def rerun(*words: str | Path) -> str:
    """Run Rerun's program; return what it prints."""
    done = subprocess.run([str(RERUN), *map(str, words)], capture_output=True, text=True, timeout=120)
    told = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)
    assert done.returncode == 0, told
    return told


@pytest.mark.parametrize("dtype", ["u1", "<u2", "<i2", "<i4", "<f4", "<f8"])
def test_pads_are_images_signals_are_known_and_nothing_is_wrong(tmp_path: Path, dtype: str) -> None:
    rng = np.random.default_rng(0)
    recording = Recording(
        {
            "tip": Pad(rng.integers(0, 100, (50, 16, 8)).astype(dtype), pitch_m=0.002),
            "palm": Pad(rng.integers(0, 100, (50, 5, 9)).astype(dtype)),
        },
        time_s=np.arange(50) / 100,
        unit="kPa",
        signals={"shear": Signals(rng.normal(0, 1, (50, 3)), ("x", "y", "z"))},
        marks=(Mark(10, "cone"), Mark(30, None)),
    )
    file = tmp_path / "hand.mcap"
    write(recording, file)
    checked = rerun("mcap", "check", "--full", file)
    topics = re.findall(r"^(\w+) .*(/[\w/]+) +(\S.*)$", checked, re.MULTILINE)
    assert {topic for _, topic, _ in topics} >= {"/tip", "/palm", "/shear"}
    assert {state for state, _, _ in topics} == {"ok"}
    made = tmp_path / "hand.rrd"
    rerun("mcap", "convert", file, "-o", made)
    told = rerun("rrd", "stats", made)
    assert re.search(r"(Depth)?Image:buffer", told)
    assert "/tip" in told
    assert "/shear" in told
