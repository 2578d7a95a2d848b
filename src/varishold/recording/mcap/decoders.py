"""What takes values out of messages: many at a time where they are laid out alike."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.recording.mcap.container import Channel
from varishold.recording.mcap.image_message import ImageLayout, image_layout, images
from varishold.recording.mcap.numbers_message import NumbersLayout, numbers_layout
from varishold.recording.mcap.parts import Decoder, MessageError, Part, joined
from varishold.recording.mcap.topics import IMAGE, NUMBERS, TYPE
from varishold.recording.mcap.understood import Understood

__all__ = ["decoder_of"]

_TYPE = re.compile(r"[<>|][iuf][1248]")
_NUMBERS: Mapping[str, str] = dict(NUMBERS.values())


def decoder_of(channel: Channel) -> Decoder:
    """Return what reads a channel.

    Raises
    ------
    InputError
        If messages of its type or in its coding cannot be taken apart.
    """
    told = channel.metadata.get(TYPE, "")
    dtype = np.dtype(told) if _TYPE.fullmatch(told) else None
    if channel.encoding in ("cdr", "ros1") and channel.type == IMAGE:
        return Images(dtype, ros1=channel.encoding == "ros1")
    if channel.encoding == "cdr" and channel.type in _NUMBERS and dtype is not None:
        return Numbers(np.dtype(_NUMBERS[channel.type]), dtype)
    return Understood(channel)


class _Alike(ABC):
    """Messages that are mostly laid out alike, so that runs of them are taken apart at once."""

    def read(self, messages: list[bytes]) -> list[Part]:
        parts, begun = [], 0
        for k, message in enumerate(messages):
            if not self._fits(message):
                if k > begun:
                    parts.append(self._take(messages[begun:k]))
                begun = k
                try:
                    self._learn(message)
                except ValueError as error:
                    raise MessageError(k, str(error)) from None
        parts.append(self._take(messages[begun:]))
        stamps = [stamp for stamp, _ in parts if stamp is not None]
        values = joined([values for _, values in parts])
        return [Part("", np.arange(len(messages)), joined(stamps) if stamps else None, None, values, None)]

    @abstractmethod
    def _fits(self, message: bytes) -> bool:
        """Tell whether a message is laid out as the one that was learned last."""

    @abstractmethod
    def _learn(self, message: bytes) -> None:
        """Learn how a message is laid out; raises ValueError where it is not what its type says."""

    @abstractmethod
    def _take(self, messages: list[bytes]) -> tuple[NDArray[np.int64] | None, NDArray[Any]]:
        """Return the stamps, if they have any, and the values of messages that fit."""


class Images(_Alike):
    """Images of one shape, in whichever encoding each of them is.

    Parameters
    ----------
    dtype : dtype, optional
        Of the values that were written. Default: that of the first image.
    ros1 : bool
        Whether they are messages of ROS 1.
    """

    def __init__(self, dtype: np.dtype[Any] | None, *, ros1: bool = False) -> None:
        self._dtype, self._ros1 = dtype, ros1
        self._layout: ImageLayout | None = None

    def _fits(self, message: bytes) -> bool:
        return self._layout is not None and self._layout.fits(message)

    def _learn(self, message: bytes) -> None:
        layout, before = image_layout(message, ros1=self._ros1), self._layout
        # Numbers that no float holds are written as their bytes.
        packed = self._dtype is not None and layout.channels == self._dtype.itemsize and layout.dtype.itemsize == 1
        if layout.channels != 1 and not packed:
            raise ValueError(f"has {layout.channels} numbers a pixel; pressure has one")
        if before is not None and (layout.rows, layout.cols) != (before.rows, before.cols):
            raise ValueError(
                f"has {layout.rows} x {layout.cols} pixels, those before have {before.rows} x {before.cols}"
            )
        if self._dtype is None:
            self._dtype = layout.dtype.newbyteorder("=")
        self._layout = layout

    def _take(self, messages: list[bytes]) -> tuple[NDArray[np.int64] | None, NDArray[Any]]:
        assert self._layout is not None
        assert self._dtype is not None
        stamps, values = images(messages, self._layout)
        if self._layout.channels > 1:
            # Bytes as channels are put together again.
            values = values.view(self._dtype.newbyteorder("<"))
        return stamps, _typed(values[..., 0], self._dtype)


class Numbers(_Alike):
    """Multi-arrays of one shape, as they are written here.

    Parameters
    ----------
    coded : dtype
        Of the numbers in the message.
    dtype : dtype
        Of the values that were written.
    """

    def __init__(self, coded: np.dtype[Any], dtype: np.dtype[Any]) -> None:
        self._coded, self._dtype = coded, dtype
        self._layout: NumbersLayout | None = None

    def _fits(self, message: bytes) -> bool:
        return self._layout is not None and self._layout.fits(message)

    def _learn(self, message: bytes) -> None:
        layout, before = numbers_layout(message, self._coded), self._layout
        if before is not None and layout.shape != before.shape:
            raise ValueError(f"has numbers of shape {layout.shape}, those before have {before.shape}")
        self._layout = layout

    def _take(self, messages: list[bytes]) -> tuple[NDArray[np.int64] | None, NDArray[Any]]:
        assert self._layout is not None
        data = b"".join([message[len(self._layout.head) :] for message in messages])
        values = np.frombuffer(data, self._layout.dtype).reshape(len(messages), *self._layout.shape)
        return None, _typed(values, self._dtype)


def _typed(values: NDArray[Any], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return values in the type in which they were given."""
    with np.errstate(invalid="ignore", over="ignore"):
        return values.astype(dtype, copy=False)
