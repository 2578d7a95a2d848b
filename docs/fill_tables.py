"""Put recorded figures into the tables of the README and the site: ``python -m docs.fill_tables [--check]``.

`docs/tables/` holds the tables as they are written, each by the name of its page. ``{BENCHMARK: FIGURE|FORMAT}`` stands
there for a figure of `benchmarks/history/`; one that is not recorded yet stands there as it was printed. With
``--check`` nothing is written, and the status is 1 where a page has another table.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks._history import History
from varishold.files import atomic_write

HERE = Path(__file__).parent
PAGES = {HERE / "tables" / "README.md": HERE.parent / "README.md", HERE / "tables" / "figures.md": HERE / "figures.md"}
#: The class of machine whose figures the tables show, on whichever machine they are made.
MACHINE = "x86_64-2"
_BETWEEN = re.compile(r"(?<=<!-- made by docs/fill_tables.py -->\n\n).*?(?=\n<!-- as far as here -->)", re.DOTALL)


def filled(table: str, history: History) -> str:
    """Return a table with the figures that it asks for.

    Raises
    ------
    KeyError
        If one was never recorded.
    """

    def told(asked: re.Match[str]) -> str:
        kept = history.before(asked["benchmark"]) or {"figures": []}
        values = {each["name"]: each["value"] for each in kept["figures"]}
        if values.get(asked["figure"]) is None:
            raise KeyError(f"{asked['benchmark']} has no recorded figure {asked['figure']!r}")
        said = format(values[asked["figure"]], asked["format"])
        # As the pages write it: .3, not 0.3.
        return re.sub(r"^0(?=\.\d*[1-9])", "", said).replace("%", " %")

    return re.sub(r"\{(?P<benchmark>\w+): (?P<figure>[^{}|]+)\|(?P<format>[^{}|]*)\}", told, table)


def main(words: Sequence[str]) -> int:
    """Write the tables, or compare them; return an exit status."""
    history, status = History(machine=MACHINE), 0
    for template, page in PAGES.items():
        text, table = page.read_text("utf-8"), filled(template.read_text("utf-8"), history)
        new, number = _BETWEEN.subn(lambda _, table=table: table, text)
        if number != 1:
            print(f"{page.name}: has {number} places for a table, expected 1", file=sys.stderr)
            status = 1
        elif new != text and "--check" in words:
            print(f"{page.name}: its table is not that of {template}: python -m docs.fill_tables", file=sys.stderr)
            status = 1
        elif new != text:
            with atomic_write(page) as file:
                file.write(new.encode())
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
