"""What an MCAP file begins and ends with."""

from __future__ import annotations

__all__ = ["MAGIC"]

MAGIC = b"\x89MCAP0\r\n"
