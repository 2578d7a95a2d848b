"""The templates of the writers, read from the package; jinja2 is loaded when a source is written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold.errors import MissingExtraError

if TYPE_CHECKING:
    from jinja2 import Environment

__all__ = ["render"]


def render(template: str, **values: object) -> str:
    """Fill in a template; a name that the template uses and `values` lacks is an error."""
    return _environment().get_template(template).render(**values)


def _environment() -> Environment:
    try:
        from jinja2 import Environment, PackageLoader, StrictUndefined
    except ImportError:
        raise MissingExtraError("writing C or Verilog needs jinja2; run: pip install jinja2") from None
    return Environment(
        loader=PackageLoader("varishold.circuit.writers", "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # the output is source code; names pass through `names`
    )
