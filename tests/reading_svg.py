"""Reads what a page draws: elements, the points of a path in screen units, the pixels of a picture."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ElementTree
from itertools import pairwise

import cv2
import numpy as np

__all__ = ["area_of", "box_of", "drawn", "legible", "paths_of", "picture_of", "said", "screen_points"]

_COMMAND = re.compile(r"([MLHVAmlhvaz])|(-?(?:\d+\.?\d*|\.\d+)(?:e-?\d+)?)")
# A letter is about so wide and so high, in the units of a drawing.
_LETTER, _LINE = 5.2, 9.0


def drawn(markup):
    """Return a drawing's root; it must be well-formed."""
    return ElementTree.fromstring(re.sub(r"^<svg ", '<svg xmlns:x="x" ', str(markup)))


def of_class(root, name):
    """Return every element of a class, in the order in which they are painted."""
    return [each for each in root.iter() if name in each.get("class", "").split()]


def said(root):
    """Return the text of every text element."""
    return ["".join(each.itertext()) for each in root.iter("text")]


def paths_of(d):
    """Return the points of each part of a path, and the ends of its arcs, in the path's own units."""
    parts, at, command, numbers = [], np.zeros(2), "", []
    needs = {"M": 2, "L": 2, "H": 1, "V": 1, "A": 7}

    def step():
        nonlocal at, numbers, command
        values, numbers = numbers, []
        base = at if command.islower() else np.zeros(2)
        if command.upper() == "H":
            at = np.array([values[0] + base[0], at[1]])
        elif command.upper() == "V":
            at = np.array([at[0], values[0] + base[1]])
        else:
            at = base + np.array(values[-2:])
        if command.upper() == "M":
            parts.append([])
            command = "L" if command == "M" else "l"
        parts[-1].append(at)

    for letter, number in _COMMAND.findall(d):
        if letter in ("z", "Z"):
            at = parts[-1][0]
        elif letter:
            assert not numbers, d
            command = letter
        else:
            numbers.append(float(number))
            if len(numbers) == needs[command.upper()]:
                step()
    assert not numbers, d
    return [np.array(part) for part in parts]


def _moves(root):
    """Return for each element its move: (shift x, shift y, scale)."""
    found = {}

    def walk(element, shift, scale):
        for kind, inner in re.findall(r"(translate|scale)\(([^)]*)\)", element.get("transform", "")):
            numbers = [float(n) for n in inner.replace(",", " ").split()]
            if kind == "translate":
                shift = shift + scale * np.array([*numbers, 0.0][:2])
            else:
                assert len(numbers) == 1
                scale = scale * numbers[0]
        found[element] = (shift, scale)
        for child in element:
            walk(child, shift, scale)

    walk(root, np.zeros(2), 1.0)
    return found


def screen_points(root, element):
    """Return an element's points in the units of the view box, a list of parts."""
    shift, scale = _moves(root)[element]
    number = lambda name: float(element.get(name, 0))  # noqa: E731
    if element.tag == "path":
        parts = paths_of(element.get("d"))
    elif element.tag in ("rect", "image"):
        x, y, wide, high = map(number, ("x", "y", "width", "height"))
        parts = [np.array([[x, y], [x + wide, y], [x + wide, y + high], [x, y + high]])]
    elif element.tag == "circle":
        x, y, r = map(number, ("cx", "cy", "r"))
        parts = [np.array([[x - r, y], [x, y - r], [x + r, y], [x, y + r]])]
    else:
        parts = [np.array([[number("x"), number("y")]])]
    return [shift + scale * part for part in parts]


def box_of(root, element):
    """Return (left, top, right, bottom) of an element in the units of the view box."""
    points = np.concatenate(screen_points(root, element))
    return (*points.min(axis=0), *points.max(axis=0))


def area_of(polygon):
    """Return the area within a closed polygon, positive where it turns from +x toward +y."""
    x, y = np.asarray(polygon).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def picture_of(element):
    """Return the pixels of an image, red, green, blue and how solid, of shape (rows, cols, 4)."""
    href = element.get("href") if hasattr(element, "get") else element
    data = np.frombuffer(base64.b64decode(href.removeprefix("data:image/png;base64,")), np.uint8)
    pixels = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    if pixels.ndim == 3 and pixels.shape[2] == 4:
        return pixels[..., [2, 1, 0, 3]]
    return np.dstack([pixels[..., ::-1], np.full(pixels.shape[:2], 255, np.uint8)])


def _text_box(root, text):
    ((x, y),) = screen_points(root, text)[0]
    wide = _LETTER * len("".join(text.itertext()))
    start = {"end": 1.0, "middle": 0.5}.get(text.get("text-anchor"), 0.0) * wide
    return x - start, y - _LINE, x - start + wide, y


def legible(root):
    """Every mark and every text lies within the view box, and no text covers another."""
    left, top, wide, high = map(float, root.get("viewBox").split())
    boxes = [_text_box(root, text) for text in root.iter("text")]
    marks = [
        box_of(root, each)
        for each in root.iter()
        if each.tag in ("path", "rect", "image", "circle") and (each.get("d") != "")
    ]
    for box in (*boxes, *marks):
        assert box[0] >= left - 0.5, box
        assert box[1] >= top - 0.5, box
        assert box[2] <= left + wide + 0.5, box
        assert box[3] <= top + high + 0.5, box
    for k, a in enumerate(boxes):
        for b in boxes[k + 1 :]:
            assert min(a[2], b[2]) <= max(a[0], b[0]) or min(a[3], b[3]) <= max(a[1], b[1]), (a, b)


def even(values):
    """Return the step of evenly spaced values."""
    steps = [b - a for a, b in pairwise(values)]
    assert max(steps) - min(steps) <= 0.11
    return sum(steps) / len(steps)
