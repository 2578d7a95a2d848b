"""What the command prints of a felt surface, and when."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
pytest.importorskip("scipy", reason="SciPy is not installed; pip install -e '.[skin]'")

import varishold.exploration
import varishold.perceive
from varishold.cli import felt_surface
from varishold.errors import InputError
from varishold.exploration import SurfaceTouch
from varishold.hand import HandSetting, PadSetting
from varishold.perceive import SurfaceMesh
from varishold.skin import Taxels


def felt() -> Any:
    corners = np.array([[0.0, 0, 0], [0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.02]])
    mesh = SurfaceMesh(corners, np.array([[0, 2, 1], [0, 3, 2], [0, 1, 3]]), np.zeros(4))
    return SimpleNamespace(
        mesh=mesh,
        touches=(SurfaceTouch("search"), SurfaceTouch("fingertip", 0.5, 0.01, (0.1, -0.2))),
        felt=(SimpleNamespace(point_m=np.zeros((1, 3))), SimpleNamespace(point_m=np.zeros((4, 3)))),
        history_m=(math.nan, 0.002),
        surface=SimpleNamespace(least_known=lambda given: (np.array([0.1, 0.2, 0.3]), 0.004 if given is mesh else 9)),
    )


def test_the_line_for_programs_holds_this() -> None:
    some = felt()
    said = felt_surface.surface_to_dict(some, Path("a/felt.stl"))
    assert json.loads(json.dumps(said)) == {
        "file": str(Path("a/felt.stl")),
        "touches": [
            {
                "touch": "search",
                "turn_rad": 0.0,
                "height_m": 0.0,
                "place_m": [0.0, 0.0],
                "points": 1,
                "mean_sigma_m": None,
            },
            {
                "touch": "fingertip",
                "turn_rad": 0.5,
                "height_m": 0.01,
                "place_m": [0.1, -0.2],
                "points": 4,
                "mean_sigma_m": 0.002,
            },
        ],
        "vertices": 4,
        "faces": 3,
        "volume_m3": some.mesh.volume_m3,
        "least_known_m": [0.1, 0.2, 0.3],
        "least_known_sigma_m": 0.004,
    }


def test_touches_are_those_of_a_surface() -> None:
    path = Path("felt.stl")
    assert felt_surface.touches_wanted(None, None) == felt_surface.touches_wanted(None, path) == 12
    assert [felt_surface.touches_wanted(n, path) for n in (2, 16)] == [2, 16]
    for n in (0, 1, 17):
        with pytest.raises(InputError, match=rf"touches must lie in 2 \.\. 16, got {n}"):
            felt_surface.touches_wanted(n, path)
    with pytest.raises(InputError, match="--touches are those of a surface: name its file with --surface"):
        felt_surface.touches_wanted(0, None)


@pytest.mark.parametrize("search", [False, True])
@pytest.mark.parametrize("as_json", [False, True])
def test_people_read_each_touch_and_programs_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], search: bool, as_json: bool
) -> None:
    some, order, settings, path = felt(), [], [], Path("felt.stl")
    pads = PadSetting(taxels=Taxels(noise=0.04))

    def explore(name: str, size_m: float, *, seed: int, touches: int, setting: Any, on_touch: Any) -> Any:
        settings.append((name, size_m, seed, touches, setting))
        order.append("feel")
        for k in range(2):
            on_touch(k + 1, some.touches[k], some.felt[k], some.history_m[k])
        return some

    monkeypatch.setattr(varishold.exploration, "explore_surface", explore)
    monkeypatch.setattr(varishold.perceive, "write_stl", lambda *words: order.append(words))

    def feel(file: Path | None) -> Any:
        return felt_surface.answer_and_feel(
            lambda more: order.append(more),
            "ball",
            0.06,
            file,
            seed=5,
            touches=2,
            setting=HandSetting(search=search, pads=pads),
            json=as_json,
        )

    assert feel(path) is some
    ((name, size_m, seed, touches, setting),) = settings
    assert (name, size_m, seed, touches) == ("ball", 0.06, 5, 2)
    assert (setting.search, setting.clamped, setting.pads) == (search, True, pads)
    out = capsys.readouterr().out
    if as_json:
        assert out == ""
        assert order == ["feel", (path, some.mesh), {"surface": felt_surface.surface_to_dict(some, path)}]
    else:
        assert order == [{}, "feel", (path, some.mesh)]
        assert " ".join(out.split()) == (
            "1 searched and gripped it: 1 point; no surface yet "
            "2 came down with a fingertip from 29°: 4 points; known to 2.0 mm on the mean "
            "The surface after 2 touches: 0 cm³ within, known to 2.0 mm on the mean, "
            "worst to 4.0 mm at (100, 200, 300) mm; mesh: felt.stl"
        )
    order.clear()
    assert feel(None) is None
    assert order == [{}]
