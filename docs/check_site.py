"""Check the site that was built: ``python docs/check_site.py out/site``.

Every link within it leads somewhere, every public name is told, no page is heavier than 300 kB without its pictures
and the index of the search.
Links that leave the site are listed, not followed. Ends with status 1 where something is wrong.
"""

from __future__ import annotations

import importlib
import sys
import zlib
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from conf import rooms

MOST_BYTES = 300_000


class Page(HTMLParser):
    """The links and the anchors of a page, and the styles and scripts that come with it.

    Parameters
    ----------
    path : Path
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.brought: set[str] = set()
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take one tag."""
        said = {key: value or "" for key, value in attrs}
        self.anchors.update(value for key, value in said.items() if key in ("id", "name"))
        link = said.get("href" if tag in ("a", "link") else "src", "")
        if link:
            self.links.append(link)
        if (tag == "link" and said.get("rel") == "stylesheet") or tag == "script":
            self.brought.add(link)


def faults(site: Path, pages: Mapping[Path, Page]) -> Iterator[str]:
    """Yield what is wrong with a site."""
    for path, page in pages.items():
        where = path.relative_to(site)
        for link in page.links:
            target = aimed_at(path, link)
            if target is None:
                continue
            if not target.exists():
                yield f"{where}: {link} leads nowhere"
            elif (
                (anchor := unquote(urlsplit(link).fragment)) and target in pages and anchor not in pages[target].anchors
            ):
                yield f"{where}: {link} has no such place"
        files = {path} | {target for link in page.brought if (target := aimed_at(path, link)) is not None}
        n_bytes = sum(file.stat().st_size for file in files if file.is_file() and file.name != "searchindex.js")
        if n_bytes > MOST_BYTES:
            yield f"{where}: {n_bytes} bytes without pictures"
    yield from (f"{name} is told nowhere" for name in untold(site))


def aimed_at(page: Path, link: str) -> Path | None:
    """Return the file that a link leads to; None where it leaves the site."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return None
    target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    return target / "index.html" if target.is_dir() else target


def untold(site: Path) -> Iterator[str]:
    """Yield the public names that the reference does not have."""
    # Four lines of head, and then packed: one line a name, its kind behind it.
    packed = (site / "objects.inv").read_bytes().split(b"\n", 4)[4]
    listed = [line.split(" ")[:2] for line in zlib.decompress(packed).decode("utf-8").splitlines()]
    told = {name for name, kind in listed if kind.startswith("py:")}
    for room in rooms():
        package = importlib.import_module(f"varishold.{room}")
        for name in package.__all__:
            home = ".".join(getattr(getattr(package, name), "__module__", "").split(".")[:2])
            if not {f"varishold.{room}.{name}", f"{home}.{name}"} & told:
                yield f"varishold.{room}.{name}"


def main(site: Path) -> int:
    """Print what is wrong and what leads out; return an exit status."""
    pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
    out = {link.partition("#")[0] for page in pages.values() for link in page.links if urlsplit(link).netloc}
    found = sorted(set(faults(site, pages)))
    print(*found, sep="\n", end="\n" if found else "")
    print(f"{len(pages)} pages, {len(found)} faults; links that leave the site, not followed:")
    print(*(f"  {link}" for link in sorted(out)), sep="\n")
    return int(bool(found) or not pages)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
