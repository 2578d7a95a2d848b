"""Learning, exports, the yardstick, the doctor: a command asks for what its options say, and tells what it got."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.commands_said import said

from varishold.cli import distortions, doctor, learn
from varishold.cli.decision_file import exported_decision
from varishold.cli.options import classifier_of
from varishold.errors import InputError
from varishold.evaluation.yardstick import FRAMES, SEED, SHAPES
from varishold.learning import PortableClassifier, TactileClassifier

# Learning


def test_a_classifier_is_as_the_options_say(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = classifier_of(None, None, None, portable=False)
    assert type(usual) is TactileClassifier
    assert usual.get_params() == TactileClassifier().get_params()
    own = classifier_of(True, False, 0.2, portable=False)
    assert own.get_params() == TactileClassifier(position=True, absolute=False, error=0.2).get_params()
    small = classifier_of(None, None, 0.2, portable=True)
    assert type(small) is PortableClassifier
    assert small.error == 0.2
    assert classifier_of(None, None, None, portable=True).error == PortableClassifier().error
    for position, absolute, word in ((True, None, "position"), (None, False, "no-absolute")):
        with pytest.raises(InputError, match=f"looks neither at places nor at loads: leave out --{word}"):
            classifier_of(position, absolute, None, portable=True)


LABELS = ("cup", "can") * 2


class Learner:
    """Stands for a classifier: notes what it learns, and answers by the presses' numbers."""

    def __init__(self) -> None:
        self.told: dict[str, Any] = {}
        self.classes_, self.remarks_ = ["a", "b", "c"], ["one group"]
        self.loss_ = math.log(2)

    def fit(self, presses: Any, labels: Any, groups: Any, *, tick: Callable[[], None]) -> None:
        tick()
        self.told.update(fit=(presses, labels, groups))

    def add(self, label: str, presses: Any) -> None:
        self.told.update(add=(label, presses))

    def remarks_on(self, presses: Any) -> tuple[str, ...]:
        return ()

    def adapt(self, presses: Any) -> Learner:
        self.told.update(adapt=presses)
        self.adapted_to_ = len(presses)
        self.learned_ = SimpleNamespace(drift={"touch": np.array([0.0, 0.5])})
        return self

    def explain(self, presses: Any) -> Any:
        self.told.setdefault("explained", []).append(presses)
        return [SimpleNamespace(to_dict=lambda press=press: {"label": press}, refused=False) for press in presses]


@pytest.fixture
def learner(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Learner:
    made = Learner()
    monkeypatch.chdir(tmp_path)
    for name in ("a.npz", "b.npz", "m.npz"):
        Path(name).touch()
    read = made.told.setdefault("read", [])
    monkeypatch.setattr(
        "varishold.cli.recordings.read_upright", lambda file, sensor: read.append((file, sensor)) or f"read {file}"
    )
    monkeypatch.setattr(
        "varishold.cli.recordings.odd_recordings",
        lambda files, recordings: [f"{file}: odd" for file in files if file == "b.npz"],
    )
    monkeypatch.setattr(
        "varishold.touch.course.presses.cut_presses", lambda recording: [f"{recording} {k}" for k in "12"]
    )
    monkeypatch.setattr("varishold.learning.read_model", lambda path: made)
    monkeypatch.setattr("varishold.learning.write_model", lambda model, path: made.told.update(written=(model, path)))
    monkeypatch.setattr("varishold.files.check_output", lambda *what, **how: made.told.update(checked=(what, how)))

    def labelled(recordings: Any, **how: Any) -> Any:
        made.told.update(how, recordings=list(recordings))

        class Given:
            presses, labels, groups = "presses", LABELS, "groups"

            def __len__(self) -> int:
                return 9

        return Given()

    monkeypatch.setattr("varishold.learning.labelled_presses", labelled)
    monkeypatch.setattr(
        learn, "classifier_of", lambda *how, portable: made.told.update(classifier=(*how, portable)) or made
    )
    return made


def test_a_model_is_learned_as_the_options_say(learner: Learner) -> None:
    lines = said("learn", "a.npz", "b.npz", "--label", "thing", "-o", "out.npz").splitlines()
    assert lines == [
        "out.npz: 9 presses of 3 things; held out, the true thing has p = 0.50 on the geometric mean",
        "note: b.npz: odd",
        "note: one group",
    ]
    told = learner.told
    assert (told["read"], told["recordings"]) == ([("a.npz", None), ("b.npz", None)], ["read a.npz", "read b.npz"])
    assert (told["label"], told["group"]) == ("thing", None)
    assert told["classifier"] == (None, None, None, False)
    assert (told["fit"], told["written"]) == (("presses", LABELS, "groups"), (learner, Path("out.npz")))
    words = ("--group", "day", "--position", "--no-absolute", "--error", 0.2, "--portable", "--sensor", "mat")
    said("learn", "a.npz", "--label", "thing", "-o", "out.npz", *words)
    assert (told["group"], told["classifier"], told["read"][-1]) == ("day", (True, False, 0.2, True), ("a.npz", "mat"))
    with pytest.raises(InputError, match="what names the things is not said"):
        said("learn", "a.npz", "-o", "out.npz")


def test_a_class_is_added_from_its_presses(learner: Learner) -> None:
    out = said("learn", "m.npz", "--add", "cup", "b.npz", "-o", "out.npz", "--sensor", "mat")
    assert out == "note: b.npz: odd\nout.npz: cup added from 2 presses; 3 things\n"
    assert learner.told["read"] == [("b.npz", "mat")]
    assert learner.told["add"] == ("cup", ["read b.npz 1", "read b.npz 2"])
    assert learner.told["written"] == (learner, Path("out.npz"))
    # The recording that is added is never written over.
    assert learner.told["checked"] == ((Path("out.npz"), "learned"), {"inputs": ["b.npz"], "force": True})
    with pytest.raises(InputError, match="name the one model to add to, got 2 files"):
        said("learn", "m.npz", "a.npz", "--add", "cup", "b.npz", "-o", "out.npz")


@pytest.mark.parametrize("adapt", [False, True])
def test_every_press_of_every_file_is_answered(learner: Learner, adapt: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learn, "_in_words", lambda found: f"it is {found.to_dict()['label']}")
    words = ("recognize", "m.npz", "a.npz", "b.npz", "--sensor", "mat", *(("--adapt",) if adapt else ()))
    note = ["note: drift since the model was learned was estimated from these 4 presses"] if adapt else []
    presses = {file: [f"read {file} {k}" for k in "12"] for file in ("a.npz", "b.npz")}
    assert said(*words).splitlines() == note + [
        line for file in presses for line in (f"{file}:", *(f"{k:>5}  it is {p}" for k, p in enumerate(presses[file])))
    ]
    # A file is read once, whatever is asked of it.
    assert learner.told["read"] == [("a.npz", "mat"), ("b.npz", "mat")]
    assert learner.told.get("adapt") == ([press for each in presses.values() for press in each] if adapt else None)
    assert learner.told["explained"] == list(presses.values())
    assert [json.loads(line) for line in said(*words, "--json").splitlines()] == [
        {"file": file, "label": press, "press": k} for file in presses for k, press in enumerate(presses[file])
    ]


# Exports


def test_a_file_holds_a_table_or_a_model(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    home = "varishold.cli.decision_file"
    monkeypatch.setattr(f"{home}._is_table", lambda path: "table" in path.name)
    monkeypatch.setattr(f"{home}.read_parameters", lambda path: f"table {path.name}")
    small = PortableClassifier()
    monkeypatch.setattr(PortableClassifier, "networks", property(lambda self: self.held), raising=False)
    monkeypatch.setattr(f"{home}.read_model", lambda path: small if "small" in path.name else TactileClassifier())
    assert exported_decision(None) is None
    assert exported_decision(tmp_path / "table") == "table table"
    for path in (None, tmp_path / "table"):
        with pytest.raises(InputError, match="has pads by name") as caught:
            exported_decision(path, "left")
        assert caught.value.parameter == "pad"
    with pytest.raises(InputError, match="is too large for a controller: learn it again with --portable"):
        exported_decision(tmp_path / "model")
    small.held = {"left": "L"}  # type: ignore[attr-defined]
    assert exported_decision(tmp_path / "small") == exported_decision(tmp_path / "small", "left") == "L"
    small.held = {"left": "L", "right": "R"}  # type: ignore[attr-defined]
    assert exported_decision(tmp_path / "small", "right") == "R"
    for pad, got in ((None, "left, right$"), ("up", "left, right, got 'up'$")):
        with pytest.raises(InputError, match=f"small: name one of its pads, {got}"):
            exported_decision(tmp_path / "small", pad)


# The yardstick


def test_the_yardstick_is_read_as_the_options_say(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}

    def score(function: Any, **how: Any) -> Any:
        asked.update(how, function=function)
        print("a user's own words")
        return SimpleNamespace(to_dict=lambda: {"a": 1})

    monkeypatch.setattr("varishold.evaluation.yardstick.score_function", score)
    monkeypatch.setattr("varishold.evaluation.yardstick.shipped_names", "shipped names")
    monkeypatch.setattr(distortions, "_own_function", lambda name: f"function {name}")
    assert said("evaluate", "--distortions", "--json") == '{"a": 1}\n'
    usual = (SHAPES, FRAMES, SEED, "shipped", "shipped names")
    keys = ("shapes", "frames", "seed", "tested", "function")
    assert tuple(asked[key] for key in keys) == usual
    words = ("--with", "m:f", "--shape", "x".join(map(str, SHAPES[-1])), "--frames", 3, "--seed", 0)
    said("evaluate", "--distortions", "--json", *words)
    assert tuple(asked[key] for key in keys) == ((SHAPES[-1],), 3, 0, "m:f", "function m:f")
    said("evaluate", "--distortions", "--json", "--shape", "both", "--with", "shipped")
    assert tuple(asked[key] for key in keys) == usual
    with pytest.raises(InputError, match="or both, got '9x9'"):
        said("evaluate", "--distortions", "--shape", "9x9")
    for words, named in (
        (("a.npz",), "recordings"), (("--label", "x"), "--label"), (("--group", "x"), "--group"),
        (("--shots", "1"), "--shots"), (("--peers",), "--peers"), (("--no-peers",), "--no-peers"),
        (("--error", 0.1), "--error"), (("--no-position",), "--no-position"),
        (("--absolute",), "--absolute"), (("--sensor", "x"), "--sensor"),
        (("--portable",), "--portable"), (("--report", "p.html"), "--report"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=f"draws its own frames: leave out {named}$"):
            said("evaluate", "--distortions", *words)


# The doctor


def test_the_packages_of_each_extra_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = [
        "a-b>=1; extra == 'skin'",
        'c[x]>2; extra == "skin"',
        "varishold[skin]; extra == 'skin'",
        "d; extra == 'learn'",
    ]
    monkeypatch.setattr("importlib.metadata.requires", lambda name: [*wanted, "numpy>=1"])
    monkeypatch.setattr(doctor, "_version", lambda name: {"a-b": "1.5", "d": "3"}.get(name))
    found = dict(doctor._extras())
    assert list(found) == list(doctor._FOR)
    assert found["skin"] == {"a-b": "1.5", "c": None}
    assert found["learn"] == {"d": "3"}
    assert found["plots"] == {}
    assert doctor._in_words("learn", {"d": "3", "e": "4"}) == "d 3, e 4"
    lacks = doctor._in_words("plots", {"d": None, "e": "4", "f": None})
    assert lacks == "lacks d, f for figures as files; run: pip install -e '.[plots]'"
    monkeypatch.setattr("importlib.metadata.requires", lambda name: None)
    assert all(packages == {} for _, packages in doctor._extras())


@pytest.mark.parametrize(("encoding", "told"), [("UTF-8", False), ("utf8", False), ("ascii", True)])
def test_a_terminal_that_lacks_signs_is_told(
    encoding: str, told: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor, "sys", SimpleNamespace(stdout=SimpleNamespace(encoding=encoding)))
    doctor.doctor()
    last = capsys.readouterr().out.splitlines()[-1]
    assert (last == f"this terminal shows {encoding}: signs that it lacks stand as their codes") == told
