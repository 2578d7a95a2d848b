"""Wheels of other platforms: what is looked for in them."""

from __future__ import annotations

import math
from pathlib import Path
from zipfile import ZipFile

import pytest

from hostile.wheels import Wheel, bound, difference
from native import wheels
from native.build import PLATFORMS, build, machine, variants

pytestmark = pytest.mark.skipif(machine("") != ("x86_64", "linux"), reason="its kernel serves as that of a wheel")


def _wheel(folder: Path, platform: str, names: dict[str, str]) -> Wheel:
    """Pack the kernel of this machine under other names."""
    path = folder / f"varishold-0.1.0-py3-none-{platform}.whl"
    own = {library.stem: library for library in build()}
    with ZipFile(path, "w") as archive:
        for name, ours in names.items():
            archive.write(own[ours], f"varishold/kernel/{name}")
    return Wheel(path, folder / "unpacked")


def test_the_kernel_of_this_machine_is_good_for_its_own_wheel(tmp_path: Path) -> None:
    names = {f"varishold_{variant}.so": f"varishold_{variant}" for variant in variants("x86_64")}
    assert _wheel(tmp_path, "manylinux_2_17_x86_64", names).faults() == []


def test_a_library_of_another_machine_is_found(tmp_path: Path) -> None:
    names = {f"varishold_{variant}.so": f"varishold_{variant}" for variant in variants("aarch64")}
    told = [f"{name} is for another machine" for name in sorted(names)]
    assert _wheel(tmp_path, "manylinux_2_17_aarch64", names).faults() == told


def test_a_library_of_another_name_is_found(tmp_path: Path) -> None:
    wheel = _wheel(tmp_path, "win_amd64", {"varishold_baseline.so": "varishold_baseline"})
    assert wheel.faults()[0].startswith("has ['varishold_baseline.so'], not ['varishold_avx2.dll'")


def test_every_platform_has_its_variants() -> None:
    machines = {platform: machine(target) for platform, target in PLATFORMS.items()}
    assert machines["macosx_11_0_arm64"] == ("aarch64", "macos")
    assert machines["win_amd64"] == ("x86_64", "windows")
    assert set(variants("aarch64")) == {"baseline", "single"}
    assert "vh_contacts" in bound()


def test_a_platform_that_is_not_known_is_refused_before_anything_is_built(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("subprocess.run", lambda *_, **__: pytest.fail("a wheel was begun"))
    monkeypatch.setattr("sys.argv", ["wheels", "win_amd64", "win_arm64"])
    with pytest.raises(SystemExit) as ended:
        wheels.main()
    told = capsys.readouterr().err.splitlines()[-1]
    assert ended.value.code == 2
    assert "no platform 'win_arm64'" in told
    assert all(platform in told for platform in PLATFORMS)


def test_numbers_are_compared_as_numbers() -> None:
    ours = [["has", "avx2"], ["noise", "1e-9", "nan"], ["levels", "1000"]]
    theirs = [["has"], ["noise", "2e-9", "nan"], ["levels", "1001"]]
    assert difference(ours, theirs) == pytest.approx(1e-3)
    assert difference(ours, [*theirs[:2], ["levels", "nan"]]) == math.inf
    assert difference(ours, theirs[:2]) == math.inf
