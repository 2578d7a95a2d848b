"""The one way in which a package's names are loaded when they are first asked for.

A package writes its public names as any other would, the imports under ``if TYPE_CHECKING``, where type checkers and
editors read them, and `lazy_names` makes the same lines work at run time::

    __all__ = ["Answer", "recognize"]

    if TYPE_CHECKING:
        from varishold.touch.answer import Answer
        from varishold.touch.recognizer import recognize
    else:
        __getattr__, __dir__ = lazy_names(__name__, __all__)

Where a name comes from is read in the package's own compiled code, so that it is written once; and not before a name
is asked for, so that importing a package takes nothing.
"""

from __future__ import annotations

import sys
from functools import cache

# Not typing's, whose import takes longer than all of this; type checkers know it by its name.
TYPE_CHECKING = False

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from types import CodeType
    from typing import Any

__all__ = ["lazy_names", "missing_extra", "to_install"]

# What is installed with an extra only: by the room that needs it, or else by what is missing.
_EXTRA_OF_ROOM = {
    "hand": "sim",
    "exploration": "sim",
    "perceive": "sim",
    "grasp": "learn",
    "learning": "learn",
    "evaluation": "learn",
    "paper": "all",
}
_EXTRA_OF = {
    "scipy": "skin",
    "sklearn": "learn",
    "threadpoolctl": "learn",
    "matplotlib": "plots",
    "mujoco": "sim",
    "trimesh": "meshes",
    "coacd": "meshes",
    "networkx": "meshes",
    "serial": "live",
    "rosbags": "live",
    "mcap": "live",
    "h5py": "files",
    "pyarrow": "files",
    "PIL": "files",
    "zstandard": "files",
    "lz4": "files",
    "dask": "cluster",
    "distributed": "cluster",
    "zenoh": "zenoh",
    "pylsl": "lsl",
    "paho": "mqtt",
}


def lazy_names(package: str, public: Sequence[str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return the functions ``__getattr__`` and ``__dir__`` of a package.

    Parameters
    ----------
    package : str
        Its name; the packages in it are found by theirs as well.
    public : sequence of str
        Its ``__all__``.
    """
    module = sys.modules[package]
    code = sys._getframe(1).f_code

    @cache
    def sources() -> dict[str, tuple[str, str]]:
        return dict(_imports(code))

    @cache
    def inner() -> list[str]:
        from pkgutil import iter_modules

        return [found.name for found in iter_modules(module.__path__) if found.ispkg]

    def load(name: str) -> Any:
        from importlib import import_module

        if name in inner():
            value = import_module(f"{package}.{name}")
        elif name in sources():
            source, original = sources()[name]
            try:
                value = getattr(import_module(source), original)
            except ModuleNotFoundError as error:
                raise missing_extra(error) from None
        else:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        setattr(module, name, value)
        return value

    def names() -> list[str]:
        return sorted({*public, *inner(), *(name for name in vars(module) if name.startswith("__"))})

    return load, names


def missing_extra(error: ModuleNotFoundError) -> ImportError:
    """Return the error of an optional dependency that is not installed, naming its extra; any other as it is."""
    from varishold.errors import MissingExtraError

    missing = (error.name or "").partition(".")[0]
    if missing not in _EXTRA_OF:
        return error
    extra, step = _EXTRA_OF[missing], error.__traceback__
    while step is not None and step.tb_next is not None:
        step = step.tb_next
    frame = None if step is None else step.tb_frame
    while frame is not None:
        # The outermost room decides: who grips with the simulated hand needs more than its skin.
        path = frame.f_globals.get("__name__", "").removeprefix("varishold.").removeprefix("cli.")
        extra = _EXTRA_OF_ROOM.get(path.partition(".")[0], extra)
        frame = frame.f_back
    return MissingExtraError(f"this needs {missing}, which is not installed; run: {to_install(extra)}")


def to_install(extra: str) -> str:
    """Return the command that installs an extra: of the checkout that is run, or else of the installed package."""
    from pathlib import Path

    in_checkout = Path(__file__).parents[2].joinpath("pyproject.toml").is_file()
    return f"pip install -e '.[{extra}]'" if in_checkout else f"pip install 'varishold[{extra}]'"


def _imports(code: CodeType) -> Iterator[tuple[str, tuple[str, str]]]:
    """Every ``from module import name as alias`` of a module's code: the alias, the module and the name in it."""
    import dis

    module, name = "", ""
    for step in dis.get_instructions(code):
        if step.opname == "IMPORT_NAME":
            module = step.argval
        elif step.opname == "IMPORT_FROM":
            name = step.argval
        elif step.opname == "STORE_NAME" and name:
            yield step.argval, (module, name)
            name = ""
