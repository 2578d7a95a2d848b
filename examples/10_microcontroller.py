"""
Run it on the skin's own controller
===================================

The recognizer as C99 without a heap, your sensor built in. Where there is a compiler it is tried here at once.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from varishold.sensor import Sensor
from varishold.touch.writers import Export, export

# %%
# A skin of 12 x 12 taxels of eight bits. The network is kept as small whole numbers.
skin = Sensor(name="fingertip", shape=(12, 12), pitch_m=(1.5e-3, 1.5e-3), span=255.0, saturation=1.0)
with tempfile.TemporaryDirectory() as folder:
    paths = export(Export(shape=(12, 12), levels=24, sensor=skin, weights="int8"), "c", Path(folder, "firmware"))
    for path in paths:
        print(f"{path.stat().st_size:8} bytes  {path.name}")

    # %%
    # It comes with its own test: frames, and the names that Python gives them.
    if shutil.which("cc") and shutil.which("make"):
        told = subprocess.run(
            ["make", "-s", "test"], cwd=Path(folder, "firmware"), capture_output=True, text=True, check=True
        )
        print(told.stdout)
    else:
        print("no C compiler here: run `make test` in the folder where there is one")
