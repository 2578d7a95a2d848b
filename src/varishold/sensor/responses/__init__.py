"""How readings follow stress: one response a file; `RESPONSES` is their registry by the `kind` of a sensor file."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from varishold.sensor.responses.linear import Linear
from varishold.sensor.responses.logarithmic import Logarithmic
from varishold.sensor.responses.power import Power
from varishold.sensor.responses.response import Response
from varishold.sensor.responses.table import Table

__all__ = ["RESPONSES", "Linear", "Logarithmic", "Power", "Response", "Table"]

#: Every response by its kind.
RESPONSES: Mapping[str, type[Response]] = MappingProxyType(
    {each.kind: each for each in (Linear, Power, Logarithmic, Table)}
)
