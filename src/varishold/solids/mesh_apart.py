"""Takes a mesh apart in a process of its own: what it is taken apart by ends its process on some meshes."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from contextlib import suppress
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError

__all__ = ["MOST_S", "taken_apart"]

Floats = NDArray[np.float64]

#: A mesh that is not taken apart by then is given up. Seconds.
MOST_S = 120.0

# A process that wants more memory has met a mesh that cannot be taken apart. Bytes.
_MOST_MEMORY = 8 << 30


def taken_apart(vertices: Floats, faces: NDArray[np.int64], **how: float | str) -> list[Floats]:
    """Return the corners of the convex pieces of a mesh.

    Parameters
    ----------
    vertices : ndarray of shape (n, 3)
    faces : ndarray of shape (k, 3)
    how : float or str
        What ``coacd.run_coacd`` is told.

    Raises
    ------
    FormatError
        If it took longer than `MOST_S`, or the process ended before it was done.
    """
    told = io.BytesIO()
    np.savez(told, vertices=vertices, faces=faces)
    begin = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import main; main()"
    call = [sys.executable, "-c", begin, json.dumps(how)]
    # By several threads some versions cut the same mesh now in one way, now in another.
    alone = {**os.environ, "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(call, input=told.getvalue(), capture_output=True, timeout=MOST_S, check=True, env=alone)
    except subprocess.TimeoutExpired:
        raise FormatError(f"not within {MOST_S:g} s; simplify the mesh") from None
    except subprocess.CalledProcessError:
        raise FormatError("does its surface pass through itself?") from None
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as found:
        return [found[name] for name in found.files]


def main() -> None:
    """Take apart what comes on the standard input, and answer on the standard output; meant for `taken_apart` alone."""
    # What the library says of its work goes where errors do.
    with os.fdopen(os.dup(1), "wb") as answer, np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as mesh:
        os.dup2(2, 1)
        with suppress(ModuleNotFoundError):
            import resource

            resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
        coacd = import_module("coacd")
        coacd.set_log_level("error")
        pieces = coacd.run_coacd(coacd.Mesh(mesh["vertices"], mesh["faces"]), **json.loads(sys.argv[1]))
        found = io.BytesIO()
        np.savez(found, *(np.asarray(corners, dtype=np.float64) for corners, _ in pieces))
        answer.write(found.getvalue())
