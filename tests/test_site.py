"""Laws of the site: its pages are reached, its Python runs, its tutorial tells what the commands print."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from tests.pressed_things import told

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
# Pages whose Python other tests run, in folders of their own.
ELSEWHERE = {"live.md", "features.md"}
BLOCKS = [
    pytest.param(page, block, id=f"{page.stem}-{k}")
    for page in PAGES
    if page.name in {"start.md", "surfaces.md"}
    for k, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.DOTALL))
]


def test_every_page_is_reached_from_the_first() -> None:
    first = (DOCS / "index.md").read_text("utf-8")
    trees = re.findall(r"```\{toctree\}\n(.*?)```", first, re.DOTALL)
    listed = {line for tree in trees for line in tree.splitlines() if line and not line.startswith(":")}
    assert {page.stem for page in PAGES} - {"index"} <= listed
    assert {name for name in listed if "/" not in name} <= {page.stem for page in PAGES}


def test_links_lead_to_pages_and_to_places_in_them() -> None:
    places = {page.name: {_anchor(line) for line in _headings(page)} for page in PAGES}
    for page in PAGES:
        for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
            path, _, anchor = target.partition("#")
            if re.match(r"[a-z]+:", target) or path.startswith("gallery/"):
                continue
            assert not path or (DOCS / path).exists(), f"{page.name}: {target}"
            if anchor and path.endswith((".md", "")):
                assert anchor in places[path or page.name], f"{page.name}: {target}"


def _headings(page: Path) -> list[str]:
    plain = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    return re.findall(r"^#+ (.*)$", plain, re.MULTILINE)


def _anchor(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


@pytest.mark.parametrize(("page", "block"), BLOCKS)
def test_the_python_of_a_page_runs(
    page: Path, block: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    exec(compile(block, page.name, "exec"), {})
    assert capsys.readouterr().out.strip()


def test_the_tutorial_tells_what_its_commands_print(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sklearn")
    monkeypatch.chdir(tmp_path)
    text = (DOCS / "tutorial.md").read_text("utf-8")
    steps = re.findall(r"^    (python|varishold) ([^\n]*)$|```text\n(.*?)```", text, re.MULTILINE | re.DOTALL)
    printed, n_told = "", 0
    for program, words, block in steps:
        if program == "python":
            script, folder = shlex.split(words)
            namespace: dict[str, object] = {"__name__": "example"}
            exec(compile((ROOT / script).read_text("utf-8"), script, "exec"), namespace)
            main = namespace["main"]
            assert callable(main)
            main(Path(folder))
        elif program:
            answered = told(*shlex.split(words))
            assert answered.exit_code == 0, answered.output
            printed = answered.output
        else:
            n_told += 1
            for line in block.splitlines():
                assert line in printed, line
    assert n_told >= 6
