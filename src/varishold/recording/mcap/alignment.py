"""Pads that are read at times of their own, put side by side."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError

__all__ = ["Alignment", "aligned"]


def aligned(
    times: Mapping[str, NDArray[np.int64]], leaders: Collection[str] | None = None
) -> tuple[dict[str, NDArray[np.int64]], tuple[str, ...]]:
    """Return which reading of each pad every frame shows, and what there is to say about it.

    There are as many frames as the leader has readings that is read most often; of the others each frame shows the
    newest reading, and there is no frame before all have been read.

    Parameters
    ----------
    times : mapping of str to ndarray of shape (n_readings,), int64
        When each reading of each pad came, rising.
    leaders : collection of str, optional
        The pads that may be the leader. Default: all.

    Returns
    -------
    dict of str to ndarray of shape (n_frames,), int64
    tuple of str
        Remarks.

    Raises
    ------
    InputError
        If the last reading of one pad came before the first of another.

    Examples
    --------
    >>> aligned({"palm": np.array([0, 10, 20, 30]), "tip": np.array([5, 25])})[0]
    {'palm': array([1, 2, 3]), 'tip': array([0, 0, 1])}
    """
    first = next(iter(times.values()))
    if all(np.array_equal(each, first) for each in times.values()):
        return {name: np.arange(len(first)) for name in times}, ()
    leading = max(leaders or times, key=lambda name: len(times[name]))
    # A clock that was set back while it was read goes on from where it was.
    frames = np.maximum.accumulate(times[leading])
    shown = {
        name: np.arange(len(frames))
        if name == leading
        else np.searchsorted(np.maximum.accumulate(each), frames, side="right") - 1
        for name, each in times.items()
    }
    begun = max(int(np.count_nonzero(each < 0)) for each in shown.values())
    _check_begun(times, leading, begun)
    return {name: each[begun:] for name, each in shown.items()}, _remarks(times, leading, begun)


class Alignment:
    """The same, some frames at a time; the times are changed and kept.

    Parameters
    ----------
    times : mapping of str to ndarray of shape (n_readings,), int64
        Writeable. A clock that was set back goes on in them from where it was.
    leaders : collection of str
        As in `aligned`.

    Attributes
    ----------
    leading : str
    n_frames, begun : int
        Frames, and readings of the leader before the first.
    remarks : tuple of str
    """

    def __init__(self, times: Mapping[str, NDArray[np.int64]], leaders: Collection[str]) -> None:
        first = next(iter(times.values()))
        self._times = times
        self._alike = all(np.array_equal(each, first) for each in times.values())
        self.leading = max(leaders, key=lambda name: len(times[name]))
        self.begun, self.remarks = 0, tuple[str, ...]()
        for each in times.values():
            np.maximum.accumulate(each, out=each)
        if not self._alike:
            frames = times[self.leading]
            self.begun = max(int(np.searchsorted(frames, each[0], side="left")) for each in times.values())
            _check_begun(times, self.leading, self.begun)
            self.remarks = _remarks(times, self.leading, self.begun)
        self.n_frames = len(times[self.leading]) - self.begun

    def shown(self, name: str, first: int, last: int) -> NDArray[np.int64]:
        """Return which reading of a pad each of the frames first to last - 1 shows."""
        at = np.arange(first + self.begun, last + self.begun)
        if self._alike or name == self.leading:
            return at
        frames = self._times[self.leading][at[0] : at[-1] + 1] if len(at) else at
        return np.searchsorted(self._times[name], frames, side="right") - 1


def _check_begun(times: Mapping[str, NDArray[np.int64]], leading: str, begun: int) -> None:
    if begun == len(times[leading]):
        late = max(times, key=lambda name: int(times[name][0]))
        raise InputError(f"pad {late!r} is first read after the last reading of pad {leading!r}")


def _remarks(times: Mapping[str, NDArray[np.int64]], leading: str, begun: int) -> tuple[str, ...]:
    remarks = [
        f"pad {name} was read {counted(len(each), 'time')}, pad {leading} {counted(len(times[leading]), 'time')}: "
        "each frame shows its "
        "newest reading"
        for name, each in times.items()
        if name != leading and len(each) != len(times[leading])
    ]
    if begun:
        remarks.append(f"{counted(begun, 'frame is', 'frames are')} left out, which came before every pad was read")
    return tuple(remarks)
