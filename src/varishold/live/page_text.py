"""The page as one text: its style and its script inside, nothing from outside."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from importlib import resources

from varishold.report.colours import BELOW, INSIDE, palette
from varishold.report.page import page_style

__all__ = ["page_security", "page_text"]

# Colours of the scale that the page draws with.
_COLOURS = 256
# The script's parts, in their order.
_SCRIPTS = ("colours.js", "message.js", "canvas.js", "frames.js", "solid.js", "plots.js", "words.js", "live.js")


@cache
def page_text() -> str:
    """Return the page."""
    style, script = _style_and_script()
    return _own("page.html").replace("/* style */", style).replace("/* script */", script)


def page_security(host: str) -> str:
    """Return what the page may do, as a browser takes it: run its own script, and talk to whom it came from.

    Parameters
    ----------
    host : str
        The name and port that it was asked for under.
    """
    style, script = _hashes()
    return (
        f"default-src 'none'; style-src '{style}'; script-src '{script}'; connect-src 'self' ws://{host} wss://{host}; "
        "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


@cache
def _hashes() -> tuple[str, str]:
    style, script = _style_and_script()
    return _hash(style), _hash(script)


@cache
def _style_and_script() -> tuple[str, str]:
    setup = {"colours": palette(_COLOURS).hex(), "inside": INSIDE, "below": BELOW}
    script = "".join(_own(name) for name in _SCRIPTS).replace('"setup"', json.dumps(setup), 1)
    return page_style() + _own("page.css"), f'"use strict";\n(() => {{\n{script}}})();\n'


def _own(name: str) -> str:
    return resources.files("varishold.live").joinpath("page", name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
