"""The page that every report shares: one template, its style and its script inside, nothing from outside."""

from __future__ import annotations

import os
from functools import cache
from importlib import resources
from typing import Any

import jinja2
from markupsafe import Markup

from varishold.files import atomic_write

__all__ = ["page_style", "render_page", "write_page"]


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("varishold.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["style"] = _own("page.css")
    environment.globals["script"] = _own("page.js")
    environment.globals["scene_script"] = _own("scene.js")
    environment.globals["perceive_style"] = _own("perceive.css")
    environment.globals["evaluation_style"] = _own("evaluation.css")
    environment.globals["corpus_style"] = _own("corpus.css")
    return environment


def page_style() -> str:
    """Return the style that all pages share, as CSS."""
    return str(_own("page.css"))


def _own(name: str) -> Markup:
    """Return a file of the package as it is: it is ours, and holds nothing that a user wrote."""
    return Markup(resources.files("varishold.report").joinpath("templates", name).read_text(encoding="utf-8"))


def render_page(template: str, **values: Any) -> str:
    """Fill a template of the package; every value is escaped unless it is `Markup`.

    Parameters
    ----------
    template : str
        A file in the package's ``report/templates``.
    **values
        What it names; a name that is missing is an error.
    """
    return _environment().get_template(template).render(**values)


def write_page(path: str | os.PathLike[str], html: str) -> None:
    """Write a page so that a reader finds the old one or the new one, never half of one."""
    with atomic_write(path, "w") as file:
        file.write(html)
