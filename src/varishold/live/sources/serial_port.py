"""``serial:PORT?preset=NAME`` a skin on a serial port; its framing is a preset's or a file's."""

from __future__ import annotations

import errno
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from varishold.errors import InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.framed import FRAMING_OPTIONS, FramedBytes, framing_at
from varishold.live.framing import Framing
from varishold.live.sample import PadLayout, Sample
from varishold.live.sources.kind import SourceKind

if TYPE_CHECKING:
    import serial

__all__ = ["KIND", "SerialPort"]

# Bytes that are read at once, at most.
_AT_ONCE = 1 << 16
# So long an answer is waited for before it is asked again. Seconds.
_ANSWER_S = 0.2


class SerialPort:
    """A skin on a serial port.

    Parameters
    ----------
    address : str
    port : str
        The port's name, as the system has it.
    framing : Framing

    Raises
    ------
    ModuleNotFoundError
        If pyserial is not installed.
    """

    def __init__(self, address: str, port: str, framing: Framing) -> None:
        import serial

        self._address, self._name, self._framing = address, port, framing
        self._serial = serial
        self._faults: tuple[type[Exception], ...] = (OSError, *_port_errors())
        self._port: serial.Serial | None = None
        self._framed = FramedBytes(address, framing)
        self._asked_s: float

    @property
    def address(self) -> str:
        return self._address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self._framed.pads

    @property
    def damaged(self) -> int:
        """How often something was not as it should be."""
        return self._framed.damaged

    @property
    def damage(self) -> str:
        """What was wrong with the newest of it, or that no frame came in all that did."""
        return self._framed.damage or self._framed.unframed

    def open(self) -> None:
        self.close()
        self._framed.restart()
        try:
            self._port = self._serial.Serial(self._name, self._framing.baud, timeout=0, write_timeout=1, exclusive=True)
            self._port.write(self._framing.start)
            self._ask()
        except (ValueError, OverflowError) as error:
            raise InputError(f"{self._address}: {error}") from error
        except self._faults as error:
            self.close()
            if _is_no_port(error):
                raise InputError(
                    f"{self._address}: {self._name} is no serial port; varishold sources lists those that are"
                ) from error
            raise LostSourceError(f"{self._address}: {_opening_words(error)}") from error

    def read(self, timeout_s: float) -> list[Sample]:
        port, ends_s = self._port, time.monotonic() + timeout_s
        if port is None:
            raise LostSourceError(f"{self._address}: is not open")
        while True:
            try:
                port.timeout = max(0.0, ends_s - time.monotonic())
                data = port.read(1)
                data += port.read(min(port.in_waiting, _AT_ONCE)) if data else b""
                samples = self._framed.samples(data)
                if self._framing.request and (samples or time.monotonic() - self._asked_s > _ANSWER_S):
                    self._ask()
            except self._faults as error:
                if isinstance(error, LostSourceError):
                    raise
                raise LostSourceError(f"{self._address}: the port is gone ({_plain(error)})") from error
            if samples or time.monotonic() >= ends_s:
                return samples

    def close(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            try:
                port.close()
            except self._faults:
                return

    def _ask(self) -> None:
        """Ask for the next frame, where the skin wants to be asked."""
        if self._framing.request and self._port is not None:
            self._framed.expect()
            self._asked_s = time.monotonic()
            self._port.write(self._framing.request)


def _port_errors() -> tuple[type[Exception], ...]:
    """Return what a port raises that is no OSError, on this system."""
    try:
        import termios
    except ModuleNotFoundError:
        return ()
    return (termios.error,)


def _is_no_port(error: Exception) -> bool:
    """Tell whether what was opened is a file, a folder or a device without a line: it will not become a port."""
    why = error.__context__ if isinstance(error.__context__, _port_errors()) else error
    return (getattr(why, "errno", None) or next(iter(why.args), None)) in (errno.ENOTTY, errno.EISDIR)


def _opening_words(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if isinstance(error, FileNotFoundError) or number == 2:
        return "there is no such port; varishold sources lists those that are"
    if number == 13:
        return "the port may not be opened by you; on Linux, join its group: sudo usermod -aG dialout $USER"
    if number in (11, 16):
        return "the port is in use by another program"
    return f"the port cannot be opened ({_plain(error)})"


def _plain(error: Exception) -> str:
    words = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return str(words).lower()


def _make(address: Address) -> SerialPort:
    address.only(*FRAMING_OPTIONS, "baud")
    if not address.place:
        raise InputError(f"{address.text}: name the port, as in {KIND.example}")
    framing = framing_at(address)
    baud = address.whole("baud", framing.baud, least=50, most=100_000_000)
    return SerialPort(address.text, address.place, replace(framing, baud=baud))


def _found() -> list[tuple[str, str]]:
    from serial.tools.list_ports import comports

    # What has no description is called n/a.
    return [(f"serial:{port.device}", (port.description or "").replace("n/a", "")) for port in sorted(comports())]


KIND = SourceKind(
    "a skin on a serial port", "serial:/dev/ttyACM0?preset=flexitac", _make, found=_found, needs=("serial",)
)
