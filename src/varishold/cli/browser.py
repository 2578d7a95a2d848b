"""Pages shown to a person."""

from __future__ import annotations

import os
import sys

__all__ = ["show_page"]


def show_page(address: str) -> bool:
    """Open a page in the person's browser, and tell whether there was one.

    Nothing is opened where nobody sits before a screen: no terminal, or no display.
    """
    if not sys.stdout.isatty() or (sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ)):
        return False
    import webbrowser

    try:
        return webbrowser.open(address)
    except webbrowser.Error:
        return False
