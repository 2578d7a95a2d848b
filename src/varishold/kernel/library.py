"""The compiled library: found, chosen for the processor, and its functions made Python's."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from varishold.errors import MissingKernelError

__all__ = ["address", "bind", "library", "sources"]

_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
# One letter a type of argument or result.
_TYPES: dict[str, Any] = {
    "p": ctypes.c_void_p,
    "i": ctypes.c_int,
    "q": ctypes.c_int64,
    "z": ctypes.c_size_t,
    "d": ctypes.c_double,
    "": None,
}
_first_byte: Any = ctypes.c_char.from_buffer
_address_of: Any = ctypes.addressof


def address(array: NDArray[Any]) -> int:
    """Return where the numbers of an array stand: one that can be written, in one piece, and is not empty.

    The fastest of numpy's and ctypes' ways; the caller keeps the array until the call has ended.
    """
    at: int = _address_of(_first_byte(array))
    return at


def _load(variant: str) -> ctypes.CDLL:
    return _open(Path(__file__).with_name(f"varishold_{variant}{_SUFFIX}"))


def _open(path: Path) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        lost = "is missing" if not path.exists() else f"cannot be loaded ({error})"
        raise MissingKernelError(
            f"the compiled kernel {path} {lost}; install varishold again (pip install), or in a checkout build it: "
            "python native/build.py"
        ) from error


def sources() -> Path:
    """Return the folder of the library's C sources."""
    installed = Path(__file__).with_name("native")
    return installed if installed.is_dir() else Path(__file__).parents[3] / "native"


@cache
def library(variant: str = "") -> ctypes.CDLL:
    """Return the library for this processor, or the variant of a name: "single" is in single precision.

    The variable VARISHOLD_KERNEL names another file, as one that was compiled to find faults.

    Raises
    ------
    MissingKernelError
        If it was not compiled, or is not this machine's.
    """
    if variant:
        return _load(variant)
    chosen = os.environ.get("VARISHOLD_KERNEL")
    if chosen:
        return _open(Path(chosen))
    baseline = _load("baseline")
    for name, is_able in (("avx512", baseline.vh_cpu_has_avx512), ("avx2", baseline.vh_cpu_has_avx2)):
        if is_able() and Path(__file__).with_name(f"varishold_{name}{_SUFFIX}").exists():
            return _load(name)
    return baseline


def bind(name: str, arguments: str, result: str = "") -> Callable[..., Any]:
    """Return a function of the library.

    Parameters
    ----------
    name : str
        As in ``varishold.h``.
    arguments : str
        A letter for each: p a pointer (an `address`, or None), i an int, q one of 64 bits, z a size, d a double.
    result : str
        The same for what it returns; empty for nothing.

    Raises
    ------
    MissingKernelError
        As `library`, or if the library is older than the package.
    """
    try:
        function = library()[name]
    except AttributeError as error:
        raise MissingKernelError(
            f"the compiled kernel has no function {name}: it is older than the package; build it again: "
            "python native/build.py"
        ) from error
    function.argtypes = [_TYPES[letter] for letter in arguments]
    function.restype = _TYPES[result]
    return function
