"""An MJCF and the files that it names, read once and kept as bytes: nothing outside of its folder is opened."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from varishold.errors import FormatError, InputError
from varishold.files import read_bytes

__all__ = ["MjcfSource", "read_mjcf"]

# Well above what a hand takes: its text, one of its files, and all of them.
_LARGEST_XML, _LARGEST_FILE, _LARGEST_ALL = 1 << 24, 1 << 27, 1 << 28
_MOST_INCLUDES = 64
_MOST_DEPTH = 200
#: Attributes that name a file, and the compiler's that name the folder of some.
_FILES = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback", "vertexfile")
_FOLDERS = {"mesh": "meshdir", "hfield": "meshdir", "skin": "meshdir", "flexcomp": "meshdir", "texture": "texturedir"}


@dataclass(frozen=True)
class MjcfSource:
    """A model as one text and its files by the names that the text gives them.

    Parameters
    ----------
    path : str
        Where it was read from: it opens every message.
    xml : str
    files : tuple of (str, bytes)
    read : tuple of Path
        All files that it was read from.
    """

    path: str
    xml: str
    files: tuple[tuple[str, bytes], ...] = field(repr=False)
    read: tuple[Path, ...] = field(default=(), repr=False, compare=False)


def read_mjcf(path: str | os.PathLike[str]) -> MjcfSource:
    """Read an MJCF, what it includes, and its meshes and textures.

    Raises
    ------
    InputError
        If a file is missing, too large, or lies outside of the model's folder.
    FormatError
        If the text is no MJCF.
    """
    path = Path(path)
    root = _parsed(path)
    if root.tag != "mujoco":
        raise FormatError(f"{path}: begins with <{root.tag[:40]}>; a hand needs an MJCF, which begins with <mujoco>")
    texts = [path]
    _include(root, path.parent, path.parent, texts)
    # How the simulation steps and is shown is ours.
    for kind in ("option", "size", "statistic", "visual"):
        for element in root.findall(kind):
            root.remove(element)
    folders = _folders(root)
    files: dict[str, bytes] = {}
    known: dict[Path, str] = {}
    for element in root.iter():
        for name in _FILES:
            said = element.attrib.get(name)
            if said is None:
                continue
            if element.tag == "model":
                raise FormatError(f"{path}: names another model ({said[:80]}); put all of the hand into one MJCF")
            if element.tag in ("mesh", "texture", "hfield", "skin") and "name" not in element.attrib:
                element.set("name", PurePosixPath(said.replace("\\", "/")).stem)
            where = _within(path.parent, Path(folders.get(_FOLDERS.get(element.tag, ""), ""), said), path)
            if where not in known:
                content = _content(path, where)
                known[where] = f"file{len(known)}{where.suffix.lower()}"
                files[known[where]] = content
                if sum(map(len, files.values())) > _LARGEST_ALL:
                    raise InputError(f"{path}: names more than {_LARGEST_ALL >> 20} MB of files; take coarser meshes")
            element.set(name, known[where])
    return MjcfSource(str(path), ElementTree.tostring(root, encoding="unicode"), tuple(files.items()), (*texts, *known))


def _content(path: Path, where: Path) -> bytes:
    try:
        return read_bytes(where, most=_LARGEST_FILE)
    except InputError as error:
        raise InputError(f"{path}: names a file that cannot be used: {error}") from None


def _parsed(path: Path) -> ElementTree.Element:
    text = read_bytes(path, most=_LARGEST_XML)
    # What is declared could grow without bound, and no MJCF declares anything.
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise FormatError(f"{path}: declares a document type, which no MJCF does; remove it")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise FormatError(f"{path}: is no XML: {error}") from None
    if _depth(root) > _MOST_DEPTH:
        raise FormatError(f"{path}: is nested deeper than {_MOST_DEPTH} levels")
    return root


def _depth(root: ElementTree.Element) -> int:
    level, depth = [root], 0
    while level and depth <= _MOST_DEPTH:
        level, depth = [child for element in level for child in element], depth + 1
    return depth


def _include(root: ElementTree.Element, folder: Path, base: Path, read: list[Path]) -> None:
    """Put what a model includes into its place."""
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag != "include":
                continue
            said = child.attrib.get("file", "")
            if len(read) > _MOST_INCLUDES:
                raise FormatError(f"{read[0]}: includes more than {_MOST_INCLUDES} files, or itself")
            where = _within(base, Path(said), read[0])
            try:
                included = _parsed(where)
            except FormatError:
                raise
            except InputError as error:
                raise InputError(f"{read[0]}: includes a file that cannot be used: {error}") from None
            read.append(where)
            _include(included, where.parent, base, read)
            at = list(parent).index(child)
            parent.remove(child)
            for k, each in enumerate(list(included)):
                parent.insert(at + k, each)


def _folders(root: ElementTree.Element) -> dict[str, str]:
    """Folders of meshes and textures, which a compiler's attributes say; they are said no more afterwards."""
    out: dict[str, str] = {}
    for compiler in root.iter("compiler"):
        both = compiler.attrib.pop("assetdir", None)
        for name in ("meshdir", "texturedir"):
            said = compiler.attrib.pop(name, both)
            if said is not None:
                out[name] = said
        if compiler.attrib.pop("strippath", "false") == "true":
            for element, name in _named(root):
                element.set(name, PurePosixPath(element.attrib[name].replace("\\", "/")).name)
    return out


def _named(root: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, str]]:
    return ((element, name) for element in root.iter() for name in _FILES if name in element.attrib)


def _within(base: Path, said: Path, path: Path) -> Path:
    """Return where a named file is; refused where that is outside of the model's folder."""
    try:
        where = (base / said).resolve()
        inside = where.is_relative_to(base.resolve()) and not said.is_absolute()
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {str(said)[:80]!r} is no file name: {error}") from None
    if not inside:
        raise InputError(
            f"{path}: names {str(said)[:200]!r}, which lies outside of its folder; put the file beside it or below"
        )
    return where
