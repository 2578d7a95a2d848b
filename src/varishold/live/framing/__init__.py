"""Framings: how a serial skin's bytes are frames, written down in a file of a few lines.

`framing_of` reads a file or a preset; `decoder_of` gives what turns bytes into readings, however they are chopped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = ["FRAMINGS", "Decoder", "Framing", "Reading", "decoder_of", "framing_of", "read_framing"]

if TYPE_CHECKING:
    from varishold.live.framing.decoder import Decoder, Reading, decoder_of
    from varishold.live.framing.file import read_framing
    from varishold.live.framing.model import Framing
    from varishold.live.framing.presets import FRAMINGS, framing_of
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
