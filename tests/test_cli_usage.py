"""What a command is given: a wrong call is one line and status 2, help shows what there is, and values are as said."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
from click.testing import CliRunner

from varishold.cli.app import app
from varishold.cli.command import Argument, Command, Commands, Option
from varishold.recording import Pad, Recording, write


@pytest.mark.parametrize(
    ("words", "where", "told"),
    [
        (("--bogus",), "", ("no such option", "--bogus")),
        (("toch", "x.npz"), "", ("no such command 'toch'",)),
        (("grasp", "fitt"), "grasp", ("no such command 'fitt'",)),
        (("touch",), "touch", ("missing argument 'FILE...'",)),
        (("touch", "x.npz", "--frame", "0"), "touch", ("no such option", "--frame", "--frames")),
        (("touch", "x.npz", "--levels", "3"), "touch", ("'--levels'", "3 is not in the range 4<=x<=512")),
        (("touch", "x.npz", "--levels=many"), "touch", ("'--levels'", "'many' is not a valid integer")),
        (("touch", "x.npz", "--pitch-m", "2mm"), "touch", ("'--pitch-m'", "'2mm' is not a valid float")),
        (("touch", "x.npz", "-o"), "touch", ("'-o' requires an argument",)),
        (("touch", "x.npz", "--json=1"), "touch", ("'--json' does not take a value",)),
        (("touch", "export"), "touch export", ("missing option '--to'", "choose from", "c")),
        (("grasp", "fit", "x.csv", "-o", "m.json"), "grasp fit", ("missing option '--label'",)),
        (("skin", "collect", "-o", "x.npz", "--slope", "1"), "skin collect", ("'--slope' requires 2 arguments",)),
        (("learn", "x.npz", "-o", "m.npz", "--error", "nan"), "learn", ("'--error'", "nan is no number")),
        (("convert", "a.npz", "b.npz", "c.npz"), "convert", ("unexpected extra argument (c.npz)",)),
        (("evaluate",), "evaluate", ("name recordings, or --distortions",)),
        (("objects", "add", "a.stl", "--library", ""), "objects add", ("'--library'", "names nothing; '.' is")),
    ],
)
def test_a_wrong_call_is_one_line(run: Any, words: tuple[str, ...], where: str, told: tuple[str, ...]) -> None:
    status, out, err = run(*words)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"varishold: {where}: " if where else "varishold: ")
    assert err.endswith(f"(varishold {f'{where} '.lstrip()}--help)\n")
    assert all(part in err.lower() for part in map(str.lower, told))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        *(
            (("paper", "table", number, f"--{option}", value), f"--{option} belongs to Table 5, got Table {number}")
            for number, option, value in (
                ("1", "seed", "0"),
                ("2", "grasps", "4"),
                ("3", "repetitions", "2"),
                ("4", "processes", "1"),
                ("4", "finger-length", "f.png"),
            )
        ),
        (("grasp", "fit", "t.csv", "--label", "a", "-o", "m.json", "--levels", "4"), "--levels are thresholds of"),
        (("demo", "live", "--report", "page.html"), "--report is a page that is written"),
        (("live", "sim:sphere", "--json", "--host", "127.0.0.1"), "--host is of the page"),
        (("live", "sim:sphere", "--json", "--folder", "."), "--folder is of the page"),
        (
            ("hand", "collect", "--objects", "table5,cone:0.06", "--size-m", "0.07", "-o", "u.csv"),
            "--size-m is of objects that are named without a size",
        ),
    ],
)
def test_an_option_that_says_nothing_beside_the_others_is_refused(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.csv").write_text("a,switch.b\nx,0\ny,1\n")
    status, out, err = run(*words)
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert err.startswith(f"varishold: {told}")
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


@pytest.mark.parametrize("words", [(), ("grasp",)])
def test_without_a_command_help_is_shown(run: Any, words: tuple[str, ...]) -> None:
    status, out, err = run(*words)
    assert (status, err) == (2, "")
    assert out == run(*words, "--help")[1]


def test_help_fits_a_terminal_and_tells_limits_and_defaults() -> None:
    for name, command in app.commands.items():
        inner = [[name, sub] for sub in command.commands] if isinstance(command, Commands) else [name.split()]
        for words in inner:
            for columns in (60, 100):
                said = CliRunner().invoke(app, [*words, "-h"], terminal_width=columns).stdout
                assert max(map(len, said.splitlines())) <= columns
                for line in said.splitlines():
                    assert line == line.rstrip()
    said = CliRunner().invoke(app, ["grasp", "fit", "-h"], terminal_width=100).stdout
    for line in (
        "Usage: varishold grasp fit [OPTIONS] TABLE...",
        "  --label COLUMN                  Column that names the object.  [required]",
        "  -o, --output MODEL.json         Model file to write.  [required]",
        "  --levels INTEGER                Thresholds a column.  [default: 4; 1<=x<=1024]",
        "  --force                         Replace a file that this command did not make.",
    ):
        assert line in said.splitlines()


def test_what_was_typed_is_told_as_it_was_typed(run: Any, tmp_path: Path) -> None:
    write(Recording({"pad": Pad(np.ones((2, 8, 8)))}), tmp_path / "a.npz")
    for words, told in (
        (("touch", "a.npz", "--pitch-m", "-1"), "varishold: --pitch-m must be one spacing in metres"),
        (("measure", "a.npz", "-o", "a.parquet", "--pitch-m", "-1"), "varishold: a.npz: --pitch-m must be one spacing"),
        (
            ("skin", "collect", "--count", "1", "-o", "b.npz", "--gain-spread", "-1"),
            "varishold: --gain-spread of taxels",
        ),
    ):
        status, _, said = run(*words)
        assert status == 1
        assert said.startswith(told)
    # A file's own name, and a key of one.
    assert run("touch", "pitch_m.npz", "--pitch-m", "1")[2] == "varishold: pitch_m.npz: there is no such file\n"
    (tmp_path / "s.toml").write_text("pitch_m = -1\n")
    assert "s.toml: pitch_m must be" in run("touch", "a.npz", "--sensor", "s.toml", "--pitch-m", "1")[2]


class Hue(StrEnum):
    """A word of two."""

    red = "r"
    blue = "b"


def test_a_function_gets_what_its_types_say() -> None:
    told: dict[str, Any] = {}

    def command(
        first: Annotated[Path, Argument("a file")],
        more: Annotated[list[str] | None, Argument("words")] = None,
        hue: Annotated[Hue, Option("a word")] = Hue.red,
        other: Annotated[Hue | None, Option("a word")] = None,
        sizes: Annotated[list[float] | None, Option("numbers", short="-s")] = None,
        pair: Annotated[tuple[str, int] | None, Option("two")] = None,
        plain: Annotated[bool, Option("a flag")] = False,
        either: Annotated[bool | None, Option("a flag")] = None,
        given: Annotated[int, Option("a number", name="--with", min=-3)] = 1,
    ) -> None:
        """Do this.

        And say more.
        """
        told.update(locals())

    made = Command("command", callback=command)
    assert made.get_short_help_str() == "Do this."

    def got(*words: str) -> dict[str, Any]:
        told.clear()
        done = CliRunner().invoke(made, words, catch_exceptions=False)
        assert done.exit_code == 0, done.output
        return {name: value for name, value in told.items() if name != "told"}

    usual = {"more": None, "hue": Hue.red, "other": None, "sizes": None, "pair": None, "plain": False, "either": None}
    usual["given"] = 1
    assert got("a") == {"first": Path("a"), **usual}
    words = ("--hue=b", "--other", "r", "-s", "1e-3", "-s-2", "--pair", "x", "-7", "--plain", "--no-either")
    assert got("a", "b", *words, "c", "--with", "-3") == {
        "first": Path("a"), "more": ["b", "c"], "hue": Hue.blue, "other": Hue.red, "sizes": [1e-3, -2.0],
        "pair": ("x", -7), "plain": True, "either": False, "given": -3,
    }  # fmt: skip
    assert isinstance(told["hue"], Hue)
    assert got("--either", "--with=7", "--with=8", "--", "-x")["given"] == 8
    assert (told["either"], told["first"]) == (True, Path("-x"))


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("varishold to", "plain,touch"),
        ("varishold grasp f", "plain,fit"),
        ("varishold touch --fram", "plain,--frames"),
        ("varishold grasp fit --mode rob", "plain,robust"),
        ("varishold touch surf", "file,surf"),
        ("varishold touch a.npz --report pa", "file,pa"),
    ],
)
def test_a_shell_completes_what_is_begun(run: Any, monkeypatch: pytest.MonkeyPatch, words: str, found: str) -> None:
    monkeypatch.setenv("_VARISHOLD_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split()) - 1))
    status, out, err = run()
    assert (status, err) == (0, "")
    assert found in out.splitlines()
