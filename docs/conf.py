"""How the site is built: ``make docs``. The reference is written anew from the rooms' public names each time."""

from __future__ import annotations

import ast
import importlib
import importlib.metadata
import inspect
import pkgutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer

import varishold

HERE = Path(__file__).parent
#: Rooms in the order in which a signal travels; any other stands behind them.
ORDER = (
    "recording",
    "frame",
    "sensor",
    "calibration",
    "levelset",
    "touch",
    "skin",
    "solids",
    "grasp",
    "circuit",
    "perceive",
    "learning",
    "evaluation",
    "trust",
    "live",
    "corpus",
    "hand",
    "exploration",
    "report",
    "paper",
    "files",
    "kernel",
)

project = "Varishold"
author = "The Varishold developers"
release = importlib.metadata.version("varishold")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = [
    "images/*.py",
    "gallery/*.ipynb",
    "gallery/*.py",
    "gallery/**/*.md5",
    "tables/*",
    "**sg_execution_times.rst",
]
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 4
# Types in docstrings are words; one may be the name of several things.
suppress_warnings = ["config.cache", "ref.python"]

autodoc_typehints = "none"
autodoc_member_order = "groupwise"
autodoc_default_options = {"members": True}
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/\d\d_",
    "ignore_pattern": r"^(?!\d\d_)",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "show_signature": False,
    "remove_config_comments": True,
    "min_reported_time": 1e9,
}

html_theme = "furo"
html_title = "Varishold"
html_static_path: list[str] = []
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}


def rooms() -> list[str]:
    """Return the rooms that have public names, in their order."""
    there = {found.name for found in pkgutil.iter_modules(varishold.__path__) if found.ispkg} - {"cli"}
    return [room for room in ORDER if room in there] + sorted(there.difference(ORDER))


def of_other_rooms(module: str) -> dict[str, str]:
    """Return the public names of a room that another one tells of, and which."""
    package = importlib.import_module(module)
    elsewhere = {}
    for name in package.__all__:
        home = ".".join(getattr(getattr(package, name), "__module__", module).split(".")[:2])
        if home != module and name in getattr(importlib.import_module(home), "__all__", ()):
            elsewhere[name] = home
    return elsewhere


def told_values(module: str, elsewhere: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the public values of a room that are neither classes nor functions, each with the comment above it."""
    package = importlib.import_module(module)
    found = {}
    for name in package.__all__:
        value = getattr(package, name)
        if name not in elsewhere and not (inspect.isclass(value) or inspect.isroutine(value)):
            told = ModuleAnalyzer.for_module(source_of(module, name)).find_attr_docs()
            found[name] = told.get(("", name), [""])
    return found


def source_of(module: str, name: str) -> str:
    """Return the module in which a name is written, going from import to import."""
    tree = ast.parse(Path(importlib.import_module(module).__file__ or "").read_text("utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and any(alias.name == name for alias in node.names):
            return source_of(node.module, name)
    return module


def write_reference(folder: Path) -> None:
    """Write one page a room."""
    folder.mkdir(exist_ok=True)
    pages = {"varishold": "varishold"} | {room: f"varishold.{room}" for room in rooms()}
    for name, module in pages.items():
        elsewhere = of_other_rooms(module)
        said = f"{module}\n{'=' * len(module)}\n\n.. automodule:: {module}\n"
        if elsewhere:
            said += f"   :exclude-members: {', '.join(elsewhere)}\n\nFrom other rooms:\n\n"
            said += "".join(f"- :py:obj:`{home}.{each}`\n" for each, home in elsewhere.items())
        for each, comment in told_values(module, elsewhere).items():
            said += f"\n.. py:data:: {each}\n\n" + "".join(f"   {line}\n" for line in comment)
        _write(folder / f"{name}.rst", said)
    listed = "\n".join(f"   {name}" for name in pages)
    title = "Reference"
    _write(
        folder / "index.rst",
        f"{title}\n{'=' * len(title)}\n\nEvery public name. Most users need those of ``varishold`` itself; each room "
        f"has more.\n\n.. toctree::\n   :maxdepth: 1\n\n{listed}\n",
    )
    for page in folder.glob("*.rst"):
        if page.stem not in {*pages, "index"}:
            page.unlink()


def _write(path: Path, text: str) -> None:
    # What is as it was is not read again.
    if not path.is_file() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def setup(app: Sphinx) -> None:
    """Leave out what scikit-learn puts into every estimator."""

    def skip(_app: Sphinx, _what: str, name: str, _object: Any, _skip: bool, _options: Any) -> bool | None:
        return True if name.startswith("set_") and name.endswith("_request") else None

    app.connect("autodoc-skip-member", skip)


write_reference(HERE / "reference")
