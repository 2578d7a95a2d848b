"""What frames, masks, pitch, thresholds and floor must be: one validator for each, one set of limits."""

from __future__ import annotations

import contextlib
import math
import sys
from collections.abc import Iterable
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError

__all__ = [
    "MOST_LEVELS",
    "MOST_READ",
    "as_array",
    "as_floats",
    "as_floor",
    "as_given",
    "as_levels",
    "as_mask",
    "as_names",
    "as_numbers",
    "as_pitch",
    "as_positive",
    "as_usable",
    "as_valid",
    "as_whole",
    "beyond_reading",
    "falling",
    "is_masked_array",
    "is_number",
    "is_ready",
    "squarest_grid",
]

# No taxel is closer to the next, and none farther from it. Metres.
_LEAST_PITCH_M, _GREATEST_PITCH_M = 1e-9, 1e3
#: More thresholds than any converter has steps in a contact; each takes memory in every contact.
MOST_LEVELS = 1 << 16
#: No value of a frame is greater: the square of a greater one is none. The kernel has it too (``VH_MOST_READ``).
MOST_READ = 1e100
_AXES = {1: "(n,)", 2: "(rows, cols)", 3: "(n_frames, rows, cols)"}
_FLOAT64 = np.dtype(np.float64)
_NO_MASK = np.empty((0, 0), np.bool_)
_NO_THRESHOLDS = np.empty(0, np.float64)


def is_ready(array: object, ndim: int) -> TypeGuard[NDArray[np.float64]]:
    """Tell whether an array is what compiled code takes already: not empty, and not to be read only."""
    return (
        type(array) is np.ndarray
        and array.dtype is _FLOAT64
        and array.ndim == ndim
        and array.flags.carray
        and array.size > 0
    )


def is_masked_array(values: object) -> TypeGuard[np.ma.MaskedArray[Any, Any]]:
    """Tell whether values are an array of numpy.ma, which takes a while to load and is loaded where there is one."""
    return "numpy.ma" in sys.modules and isinstance(values, np.ma.MaskedArray)


def as_array(values: Any) -> NDArray[np.float64]:
    """Return a copy of numbers as float64; of what is none, or beyond all floats, an array of shape (0,)."""
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)


def as_given(values: Any, must: str) -> NDArray[Any]:
    """Return values as an array in their own type.

    Parameters
    ----------
    values : array_like
    must : str
        What they must be, to open an error with, as in "time_s must be one number a frame, shape (3,)".

    Raises
    ------
    InputError
        If they are rows of different lengths, or some are masked: what is not known is not to be believed.
    """
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{must}, got rows of different lengths") from error
    if is_masked_array(values) and np.ma.is_masked(values):
        raise InputError(f"{must}, got some that are masked")
    return array


def as_numbers(values: Any, ndim: int, name: str, *, masked: bool = False) -> NDArray[Any]:
    """Return an array of real numbers in its own type, truth values as uint8 and long floats as float64.

    Parameters
    ----------
    values : array_like
        The numbers; a memory map stays one.
    ndim : int
        2 for a frame, 3 for frames.
    name : str
        What to call it in an error.
    masked : bool
        Whether the caller asks `as_valid` or `as_usable` where a masked array's numbers count.

    Raises
    ------
    InputError
        If it is no array of `ndim` dimensions of real numbers, at least one taxel in each, or masked for a caller
        that knows no broken taxels.
    """
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{name} must be numbers of shape {_AXES[ndim]}, got rows of different lengths") from error
    if not masked and is_masked_array(values) and np.ma.is_masked(values):
        raise InputError(f"{name} must not be masked here; fill what is masked first (varishold.frame.fill_invalid)")
    if array.dtype.kind == "b":
        array = array.astype(np.uint8)
    if array.ndim != ndim or array.dtype.kind not in "iuf" or 0 in array.shape[-2:]:
        raise InputError(f"{name} must be numbers of shape {_AXES[ndim]}, got {array.dtype} of shape {array.shape}")
    return array.astype(np.float64) if array.dtype.itemsize > 8 else array


def as_floats(values: Any, ndim: int, name: str, *, masked: bool = False) -> NDArray[np.float64]:
    """Return numbers as compiled code takes them: float64, in one piece, writeable; not copied if they are so.

    Parameters
    ----------
    values, ndim, name, masked
        As in `as_numbers`.
    """
    if is_ready(values, ndim):
        return values
    array = np.ascontiguousarray(as_numbers(values, ndim, name, masked=masked), dtype=np.float64)
    return array if array.flags.writeable else array.copy()


def as_mask(mask: ArrayLike | None, shape: tuple[int, ...], name: str) -> NDArray[np.bool_]:
    """Return a mask over a frame's taxels as compiled code takes it; None is an array of no taxels.

    Parameters
    ----------
    mask : array_like of bool or None
        The mask; None where there is none.
    shape : tuple of int
        Of the frame.
    name : str
        What to call it in an error.

    Raises
    ------
    InputError
        If it is not bool, or has another shape.
    """
    if mask is None:
        return _NO_MASK
    try:
        array = np.ascontiguousarray(mask)
    except ValueError as error:
        raise InputError(f"{name} must have the shape of a frame, {shape}, got rows of different lengths") from error
    if array.dtype != np.bool_:
        raise InputError(
            f"{name} must be True or False for each taxel, got {array.dtype}; compare it first, as mask > 0"
        )
    if array.shape != shape:
        raise InputError(f"{name} must have the shape of a frame, {shape}, got {array.shape}")
    return array if array.flags.writeable else array.copy()


def as_usable(
    values: Any, shape: tuple[int, ...], field: ArrayLike | None = None, valid: ArrayLike | None = None
) -> NDArray[np.bool_]:
    """Return where there is a taxel that works: in `field`, in `valid`, and not masked by a masked array.

    Parameters
    ----------
    values, shape, valid
        As in `as_valid`.
    field : array_like of bool or None
        False where there is no taxel.
    """
    usable = np.ones(shape, np.bool_)
    for mask in (as_mask(field, shape, "field"), as_valid(values, valid, shape)):
        if mask.size:
            usable &= mask
    return usable


def as_valid(values: Any, valid: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return where taxels work, as `as_mask` does: where `valid`, and where a masked array masks no value.

    Parameters
    ----------
    values : array_like
        The frame, or frames, as they were given.
    valid : array_like of bool or None
        False where a taxel is broken.
    shape : tuple of int
        Of a frame.

    Raises
    ------
    InputError
        If `valid` is no mask of that shape, or frames mask different taxels.
    """
    works = as_mask(valid, shape, "valid")
    if not is_masked_array(values) or values.mask is np.ma.nomask:
        return works
    masked = np.ma.getmaskarray(values)
    if masked.ndim > len(shape):
        if not np.array_equal(masked.any(axis=0), masked.all(axis=0)):
            raise InputError("masked frames must mask the same taxels in every frame; fill the others first")
        masked = masked[0]
    if masked.shape != shape:
        raise InputError(f"a frame's mask must have the shape of a frame, {shape}, got {masked.shape}")
    return ~masked if works.size == 0 else works & ~masked


def as_pitch(pitch_m: ArrayLike, name: str = "pitch_m") -> tuple[float, float]:
    """Return taxel spacing as (row spacing, column spacing) in metres.

    Parameters
    ----------
    pitch_m : float or (float, float)
        One spacing for both ways, or two.
    name : str
        What to call it in an error.

    Raises
    ------
    InputError
        If it is not one number or two, from a nanometre to a kilometre.
    """
    spacing = as_array(pitch_m) if _are_real(pitch_m) else np.empty(0)
    if spacing.shape not in ((), (1,), (2,)) or not np.all(
        (spacing >= _LEAST_PITCH_M) & (spacing <= _GREATEST_PITCH_M)
    ):
        raise InputError(
            f"{name} must be one spacing in metres or (row spacing, column spacing), each from {_LEAST_PITCH_M:g} to "
            f"{_GREATEST_PITCH_M:g}, got {pitch_m!r}"
        )
    return float(spacing.flat[0]), float(spacing.flat[-1])


def is_number(value: object) -> bool:
    """Tell whether a value is one real number, Python's or numpy's, and no truth value."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def _are_real(values: Any) -> bool:
    """Tell whether values are real numbers: no truth values, no texts, nothing complex."""
    if type(values) is float:
        return True
    each = values if isinstance(values, list | tuple) else [values]
    try:
        return all(np.asarray(value).dtype.kind in "iuf" for value in each)
    except ValueError:
        return False


def as_positive(value: Any, name: str) -> float:
    """Return a positive and finite number.

    Raises
    ------
    InputError
        If it is none.
    """
    number = 0.0
    with contextlib.suppress(TypeError, ValueError, OverflowError):
        number = 0.0 if isinstance(value, str | bytes | bool | np.bool_) or np.ndim(value) else float(value)
    if not 0 < number < math.inf:
        raise InputError(f"{name} must be positive and finite, got {value!r}")
    return number


def as_whole(value: Any, name: str, least: int = 1) -> int:
    """Return a whole number from `least` on.

    Raises
    ------
    InputError
        If it is none.
    """
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer) or value < least:
        raise InputError(f"{name} must be a whole number from {least}, got {value!r}")
    return int(value)


def as_names(names: Any, what: str) -> list[str]:
    """Return several names; one text is no list of them.

    Raises
    ------
    InputError
        If they are anything else.
    """
    several = isinstance(names, Iterable) and not isinstance(names, str | bytes)
    given = list(names) if several else []
    if not several or not all(isinstance(each, str) for each in given):
        got = " ".join(repr(names).split())[:60]
        raise InputError(f"{what} must be several names, as in a list, got {got}")
    return given


def as_levels(levels: int | ArrayLike) -> tuple[int, NDArray[np.float64]]:
    """Return (so many thresholds of each contact's own, none), or (0, the same thresholds for all).

    Thresholds that compiled code can take as they are come back in the order in which they were given.

    Raises
    ------
    InputError
        If it is neither a whole number from 1 nor finite thresholds in one row, or there are too many.
    """
    if is_ready(levels, 1) and len(levels) <= MOST_LEVELS:
        return 0, levels
    if isinstance(levels, (int, np.integer)) and not isinstance(levels, bool):
        if not 1 <= levels <= MOST_LEVELS:
            raise InputError(f"levels must be 1 to {MOST_LEVELS}, got {levels}")
        return int(levels), _NO_THRESHOLDS
    must = f"levels must be a whole number or thresholds of shape (n_levels,), at most {MOST_LEVELS}"
    thresholds = as_given(levels, must)
    if thresholds.ndim != 1 or not 0 < thresholds.size <= MOST_LEVELS or thresholds.dtype.kind not in "iuf":
        raise InputError(f"{must}, got {thresholds.dtype} of shape {thresholds.shape}")
    return 0, falling(thresholds.astype(np.float64))


def falling(thresholds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return thresholds sorted along the last axis, the highest first.

    Raises
    ------
    InputError
        If one is not finite.
    """
    ordered = np.sort(thresholds, axis=-1)[..., ::-1].copy()
    if not np.isfinite(ordered).all():
        raise InputError("levels must be finite")
    return ordered


def beyond_reading(frame: NDArray[Any], what: str = "a frame") -> InputError:
    """Return the error of a frame with values beyond `MOST_READ`; it names the first infinite one, else the first."""
    wrong = np.isinf(frame)
    must = "finite" if wrong.any() else f"within +-{MOST_READ:g}"
    row, col = np.argwhere(wrong if wrong.any() else np.abs(frame) > MOST_READ)[0].tolist()
    return InputError(
        f"{what} must be {must}, got {frame[row, col]} at (row, col) = ({row}, {col}); mark broken taxels in valid"
    )


def as_floor(floor: float | None, name: str = "floor") -> float:
    """Return a floor, or a noise, -1 where None leaves it to be chosen.

    Raises
    ------
    InputError
        If it is negative or not finite.
    """
    if floor is None:
        return -1.0
    try:
        value = float(floor)
    except (TypeError, ValueError, OverflowError):
        value = np.nan
    if not 0 <= value < np.inf:
        raise InputError(f"{name} must be finite and not negative, got {floor!r}")
    return value


def squarest_grid(n_values: int) -> tuple[int, int]:
    """Return the squarest (rows, cols) that hold so many values without a rest, not more rows than columns.

    Examples
    --------
    >>> squarest_grid(12), squarest_grid(7)
    ((3, 4), (1, 7))
    """
    rows = next(k for k in range(math.isqrt(n_values), 0, -1) if n_values % k == 0)
    return rows, n_values // rows
