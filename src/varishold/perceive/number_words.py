"""What the numbers of evidence are, in a reader's words."""

from __future__ import annotations

import re

__all__ = ["number_in_words"]

# By a pattern of the name; what it leaves open stands in the words as {0}, without dots and underscores.
_WORDS = {
    r"switch\.(.+)": "switch {0}",
    r"angle_rad\.(.+)": "the angle of {0}",
    r"force_n\.(.+)": "the force of {0}",
    r"tip\.height": "how high the fingertip met it",
    r"tip\.touched": "whether the fingertip met it",
    r"form\.grip_round": "how round the grip is",
    r"form\.pads_round": "how round the surfaces under all pads are",
    r"form\.least_round": "how round the least round surface under a pad is",
    r"fit\.parts": "how many parts touch",
    r"fit\.least\.off": "how far the parts lie off the section that fits best",
    r"fit\.(.+)\.growing\.off": "how far the parts lie off a {0} that grows upward",
    r"fit\.(.+)\.off": "how far the parts lie off a {0}",
    r"fit\.(.+)\.growth": "how a {0} that fits the grip grows upward",
    r"fit\.(.+)\.growing\.ratio": "the size of a {0} that grows upward, beside a circle's",
    r"fit\.(.+)\.ratio": "the size of a {0} that fits the grip, beside a circle's",
    r"pad\.(.+)\.on": "whether pad {0} is pressed",
    r"pad\.(.+)\.curve": "how bent the surface is along the columns of pad {0}",
    r"pad\.(.+)\.curve_up": "how bent the surface is along the rows of pad {0}",
    r"pad\.(.+)\.curved": "how much likelier than flat it is curved under pad {0}",
    r"pad\.(.+)\.edge": "how much likelier than flat it is an edge under pad {0}",
    r"pad\.(.+)\.point": "how much likelier than flat it is a point under pad {0}",
    r"pad\.(.+)\.x": "where along the columns pad {0} is pressed",
    r"pad\.(.+)\.y": "where along the rows pad {0} is pressed",
    r"pad\.(.+)\.area": "how much of pad {0} is pressed",
}


def number_in_words(name: str) -> str:
    """Return what a number of evidence is; its name where it is none that this program makes.

    Examples
    --------
    >>> number_in_words("pad.ring.middle.curve_up"), number_in_words("fit.hexagon.off"), number_in_words("load")
    ('how bent the surface is along the rows of pad ring middle', 'how far the parts lie off a hexagon', 'load')
    """
    for pattern, words in _WORDS.items():
        if found := re.fullmatch(pattern, name):
            return words.format(*(re.sub("[._]", " ", part) for part in found.groups()))
    return name
