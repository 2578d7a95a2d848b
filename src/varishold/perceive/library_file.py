"""A library as one NPZ file: plain arrays, nothing pickled."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._name import plain_name, refuse_name_of_strangers
from varishold.errors import FormatError, require, require_a
from varishold.files import Archive, open_archive, open_packed_archive, parse_json, write_archive
from varishold.perceive.library import REFUSED_AT, Library
from varishold.perceive.metric import Metric
from varishold.perceive.size_model import SizeModel
from varishold.perceive.size_range import LEAST_SIZE_M, MOST_SIZE_M
from varishold.perceive.touch_model import TouchModel

__all__ = ["read_library", "read_packed_library", "shipped_library", "write_as", "write_library"]

# What is written, and what is read: files of the first kind hold whole covariance matrices.
_FORMAT, _FORMATS = "varishold library 2", ("varishold library 1", "varishold library 2")

# The shipped library: ten objects, touched by the simulated hand; and the same, lying on a side. Packed by xz, they
# take two thirds of the room.
_SHIPPED, _SHIPPED_LYING = (Path(__file__).with_name(f"{name}.npz.xz") for name in ("objects", "lying"))

# Numbers are kept in twentieths of their standard unit, sizes in 1/8000 of their logarithm; this stands for unknown.
_PER_UNIT, _PER_LOG, _NO_UNIT, _NO_LOG = 20, 8000, -128, -32768

# A metric is kept in half precision where no whitened number then changes by more than this part of those before it.
_MOST_OFF = 0.02

# What reading a file that is no library can end in, whichever byte of it is wrong.
_DAMAGE = (
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    ArithmeticError,
    RuntimeError,
    MemoryError,
)


def write_library(library: Library, path: str | os.PathLike[str]) -> None:
    """Write a library.

    Parameters
    ----------
    library : Library
    path : str or path-like
        NPZ; a file that is there is replaced only when the new one is complete.
    """
    write_as("library", library, path)


def write_as(kind: str, library: Library, path: str | os.PathLike[str]) -> None:
    """Write a library as a kind of file by which a command knows its own again, as those of another's taxels."""
    require_a(Library, library, "library", "made by from_examples or read_library")
    touches = list(library.touches)
    head: dict[str, Any] = {"format": _FORMAT, "objects": list(library.objects), "touches": touches}
    if library.hand is not None:
        head["hand"] = library.hand
    arrays: dict[str, NDArray[Any]] = {"owner": library.owner.astype(np.int16), "log_size": _narrow(library.log_size)}
    if library.refused_at != REFUSED_AT:
        head["refused_at"] = list(library.refused_at)
    if library.wider:
        head["wider"] = [[name, pose, other] for (name, pose), other in library.wider.items()]
    if library.pose is not None:
        head["poses"] = list(library.poses)
        arrays["pose"] = library.pose.astype(np.int8)
    for k, (touch, model) in enumerate(library.touches.items()):
        metric, size = model.metric, model.size
        head[f"{k}"] = {
            "touch": touch,
            "names": list(metric.names),
            "size_names": [] if size is None else list(size.names),
            "width": model.width,
            "fall": model.fall,
            "cost": model.cost,
            **({} if model.seconds is None else {"seconds": model.seconds}),
            **({} if model.own == 1 else {"own": model.own}),
        }
        logs = np.round(model.size_values * _PER_LOG)
        arrays |= {
            f"{k}.shift": metric.shift,
            f"{k}.scale": metric.scale,
            f"{k}.lower": _triangle(metric),
            f"{k}.units": _packed(metric, model.values),
            f"{k}.others": _packed(metric, model.others),
            f"{k}.logs": np.where(np.isnan(logs), _NO_LOG, np.clip(logs, -32767, 32767)).astype(np.int16),
            f"{k}.scores": model.scores.astype(np.float32),
            f"{k}.failed": model.failed,
            f"{k}.power": model.power.astype(np.float32),
        }
        if model.optimism is not None:
            arrays[f"{k}.optimism"] = model.optimism.astype(np.float16)
        if size is not None:
            arrays |= {f"{k}.line": size.line, f"{k}.size_scale": size.scale, f"{k}.size_off": size.off}
    arrays["head"] = np.array(json.dumps(head))
    write_archive(arrays, path, kind=kind)


def _narrow(values: NDArray[np.float64]) -> NDArray[Any]:
    """Return numbers in single precision where that leaves them as they are."""
    single = values.astype(np.float32)
    return single if np.array_equal(single, values, equal_nan=True) else values


def _triangle(metric: Metric) -> NDArray[Any]:
    """The covariance's lower factor row by row: its product is a covariance, however its numbers were rounded."""
    lower = np.linalg.cholesky(metric.covariance)
    with np.errstate(over="ignore"):
        half = lower.astype(np.float16)
    at = np.tril_indices(len(lower))
    if not np.isfinite(half).all() or not np.diagonal(half).all():
        return lower[at].astype(np.float32)
    off = np.linalg.solve(lower, half.astype(np.float64)) - np.eye(len(lower))
    return (half if np.abs(off).max() <= _MOST_OFF else lower.astype(np.float32))[at]


def _covariance(data: Archive, k: int, d: int) -> NDArray[np.float64]:
    """Covariance of a touch's numbers, from its lower factor; files that were written before hold the matrix."""
    if f"{k}.lower" in data.names:
        row = data.array(f"{k}.lower").astype(np.float64)
        require(row.shape == (d * (d + 1) // 2,), f"the factor of touch {k} has shape {row.shape}, not that of {d}")
        lower = np.zeros((d, d))
        lower[np.tril_indices(d)] = row
        require((np.diagonal(lower) > 0).all(), f"the factor of touch {k} must be positive on its diagonal")
        return lower @ lower.T
    whole = data.array(f"{k}.covariance").astype(np.float64)
    require(whole.shape == (d, d), f"the covariance of touch {k} has shape {whole.shape}, not {(d, d)}")
    # What stands below the diagonal stands above it too.
    upper = np.triu(whole)
    return upper + np.triu(upper, 1).T


def _packed(metric: Metric, values: NDArray[np.float64]) -> NDArray[np.int8]:
    units = np.round(metric.standardized(values) * _PER_UNIT)
    # Row by row it packs by a sixth closer.
    return np.where(np.isnan(units), _NO_UNIT, units).astype(np.int8, order="C")


def _unpacked(metric: Metric, units: NDArray[np.float64]) -> NDArray[np.float64]:
    # Of a touch that was felt in part, some columns are taken.
    return np.asfortranarray(np.where(units == _NO_UNIT, np.nan, units / _PER_UNIT) * metric.scale + metric.shift)


def read_library(path: str | os.PathLike[str]) -> Library:
    """Read a library.

    Raises
    ------
    FormatError
        If the file is no library of this version, or is damaged.
    """
    with open_archive(path) as data:
        return _read(path, data)


def read_packed_library(path: str | os.PathLike[str]) -> Library:
    """Read a library that is packed as those that are shipped.

    :meta private:
    """
    with open_packed_archive(path) as data:
        return _read(path, data)


def _read(path: str | os.PathLike[str], data: Archive) -> Library:
    try:
        # What is no number is refused, or unknown, further on.
        with np.errstate(all="ignore"):
            return _library(path, data)
    except FormatError:
        raise
    except _DAMAGE as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise FormatError(f"{path}: is no library, or it is damaged ({what})") from None


def _library(path: str | os.PathLike[str], data: Archive) -> Library:
    if "head" not in data.names:
        raise FormatError(f"{path}: is no library, as write_library and the command objects make them")
    head = parse_json(data.text("head"), where=f"{path}: head")
    if head.get("format") not in _FORMATS:
        got = ascii(head.get("format"))[:60]
        raise FormatError(f"{path}: is no library that this version reads: expected {_FORMAT!r}, got {got}")
    owner, log_size = data.array("owner").astype(np.int64), data.array("log_size").astype(np.float64)
    objects = tuple(head["objects"])
    # Files that were written before say nothing of poses.
    poses = tuple(head.get("poses", ()))
    pose = data.array("pose").astype(np.int64) if poses else None
    if pose is not None:
        lie = pose.shape == owner.shape and bool(((pose >= -1) & (pose < len(poses))).all())
        require(lie and all(isinstance(word, str) for word in poses), "examples and poses do not fit together")
    bare = Library(objects, owner, log_size, {}, None, poses, pose)
    touches = {}
    for k in range(len(head["touches"])):
        own = head[f"{k}"]
        touches[own["touch"]] = _touch(data, k, own, len(owner), len(bare.object_of_kind))
    sizes = np.exp(log_size[~np.isnan(log_size)])
    possible = (sizes >= 0.99 * LEAST_SIZE_M) & (sizes <= 1.01 * MOST_SIZE_M)
    fit = log_size.shape == owner.shape and np.array_equal(np.unique(owner), np.arange(len(objects)))
    named = objects and len(set(objects)) == len(objects) and all(plain_name(name) for name in objects)
    require(possible.all(), f"sizes must lie in [{LEAST_SIZE_M:g}, {MOST_SIZE_M:g}] m")
    require(fit, "examples and objects do not fit together")
    require(named, "objects must have names of their own, lines of printable text")
    for name in objects:
        refuse_name_of_strangers(name.strip(), "object")
    hand = head.get("hand")
    require(hand is None or isinstance(hand, str), "the hand must be a name")
    # Files that were written before refuse as most libraries do.
    early, late = (float(p_value) for p_value in head.get("refused_at", REFUSED_AT))
    require(0 < early < 1 and 0 < late < 1, "the p-values at which things are refused must lie in (0, 1)")
    whole = replace(bare, touches=touches, hand=hand, refused_at=(early, late))
    # Files that were written before say nothing of it.
    for name, lies, other in head.get("wider", ()):
        whole = whole.with_wider(name, other, pose=lies)
    return whole


def _touch(data: Archive, k: int, own: dict[str, Any], n: int, n_kinds: int) -> TouchModel:
    names = tuple(own["names"])
    d = len(names)
    arrays = {
        key: data.array(f"{k}.{key}").astype(np.float64)
        for key in ("shift", "scale", "units", "others", "logs", "scores", "failed", "power")
    }
    m = len(own["size_names"])
    shapes = {
        "shift": (d,),
        "scale": (d,),
        "units": (n, d),
        "others": (len(arrays["others"]), d),
        "logs": (n, m or arrays["logs"].shape[-1]),
        "scores": (n,),
        "failed": (n,),
        "power": (n_kinds,),
    }
    for key, shape in shapes.items():
        got = arrays[key].shape
        require(got == shape, f"{key} of touch {own['touch']!r} has shape {got}, not {shape}")
    # Of what nobody counted it is NaN.
    shares = not ((arrays["power"] < 0) | (arrays["power"] > 1)).any()
    require(shares, f"power of touch {own['touch']!r} must be shares, 0 to 1")
    metric = Metric(names, arrays["shift"], arrays["scale"], _covariance(data, k, d))
    np.linalg.cholesky(metric.covariance)
    # Files that were written before say nothing of seconds, nor of how far an example's own likelihood counts.
    seconds, own_power = own.get("seconds"), own.get("own", 1.0)
    counts = isinstance(own_power, (int, float)) and 0 < own_power <= 1
    require(counts, f"what an example counts in touch {own['touch']!r} must lie in (0, 1]")
    taken = [own["cost"]] if seconds is None else [own["cost"], seconds]
    positive = np.array([own["width"], own["fall"], *taken, *metric.scale], dtype=np.float64)
    finite = np.concatenate([positive, metric.shift, metric.covariance.ravel()])
    sound = np.isfinite(finite).all() and (positive > 0).all()
    require(sound, f"scales of touch {own['touch']!r} must be positive and finite")
    optimism = None
    # Files that were written before say nothing of it.
    if f"{k}.optimism" in data.names:
        optimism = data.array(f"{k}.optimism").astype(np.float64)
        fits = optimism.shape == (n,) and bool(np.isfinite(optimism).all())
        require(fits, f"optimism of touch {own['touch']!r} is not one number an example")
    return TouchModel(
        metric=metric,
        values=_unpacked(metric, arrays["units"]),
        size=_size_model(data, k, own, n_kinds) if m else None,
        size_values=np.where(arrays["logs"] == _NO_LOG, np.nan, arrays["logs"] / _PER_LOG),
        width=float(own["width"]),
        fall=float(own["fall"]),
        others=_unpacked(metric, arrays["others"]),
        scores=arrays["scores"],
        failed=arrays["failed"].astype(np.bool_),
        power=arrays["power"],
        cost=float(own["cost"]),
        seconds=None if seconds is None else float(seconds),
        optimism=optimism,
        own=float(own_power),
    )


def _size_model(data: Archive, k: int, own: dict[str, Any], n_kinds: int) -> SizeModel:
    line, scale = (data.array(f"{k}.{key}").astype(np.float64) for key in ("line", "size_scale"))
    # Files that were written before know a line's scale alone.
    off = data.array(f"{k}.size_off") if f"{k}.size_off" in data.names else np.zeros((n_kinds, 1))
    sized = line.shape == (n_kinds, len(own["size_names"]) + 1) and scale.shape == (n_kinds,)
    # Of an object without known sizes both are NaN.
    sized = sized and not (np.isinf(line).any() or np.isinf(scale).any() or (scale <= 0).any())
    sized &= off.ndim == 2 and off.shape[0] == n_kinds and off.shape[1] >= 1 and bool(np.isfinite(off).all())
    require(sized, f"sizes of touch {own['touch']!r} do not fit")
    return SizeModel(tuple(own["size_names"]), line, scale, off.astype(np.float64))


def shipped_library(pose: str = "upright") -> Library:
    """Return the library of ten objects as the simulated hand feels them, "upright" or "lying" on a side.

    Raises
    ------
    InputError
        If it is another pose.
    """
    shipped = {"upright": _SHIPPED, "lying": _SHIPPED_LYING}
    require(isinstance(pose, str) and pose in shipped, f"pose must be one of {', '.join(shipped)}, got {pose!r}")
    return _read_once(shipped[pose])


@cache
def _read_once(path: Path) -> Library:
    return read_packed_library(path)
