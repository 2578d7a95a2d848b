"""Pictures of a grasp, rendered offscreen by MuJoCo."""

from __future__ import annotations

import importlib
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, MissingExtraError
from varishold.files import atomic_write
from varishold.files.png import png_bytes
from varishold.hand.actions import Step
from varishold.hand.bench import Bench
from varishold.hand.grasping import Grasp, HandSetting, grasp
from varishold.hand.model import require_mujoco
from varishold.hand.scene import colour_switches

__all__ = ["Camera", "Photographer", "photograph", "tile"]

#: Ways to draw without a screen, in the order in which they are tried where MUJOCO_GL does not choose.
_BACKENDS = ("egl", "osmesa")


@dataclass(frozen=True)
class Camera:
    """Where the pictures are taken from.

    Parameters
    ----------
    azimuth_deg, elevation_deg, distance_m : float
    look_at_m : tuple of 3 floats
        Metres, in the carriage's frame; the angles are about it too.
    width, height : int
        Of one picture. Pixels.
    """

    azimuth_deg: float = 232.0
    elevation_deg: float = -30.0
    distance_m: float = 0.50
    look_at_m: tuple[float, float, float] = (0.05, 0.0, 0.0)
    width: int = 420
    height: int = 420


class Photographer:
    """Takes pictures of a bench without a screen.

    Parameters
    ----------
    bench : Bench
    camera : Camera, optional

    Raises
    ------
    MissingExtraError
        If nothing here can draw without a screen.
    """

    def __init__(self, bench: Bench, camera: Camera | None = None) -> None:
        self._camera = camera or Camera()
        self._mj = mj = require_mujoco()
        width, height = self._camera.width, self._camera.height
        self._context = _context(width, height)
        bench.model.vis.global_.offwidth, bench.model.vis.global_.offheight = width, height
        try:
            self._gl = mj.MjrContext(bench.model, mj.mjtFontScale.mjFONTSCALE_100.value)
        except Exception as error:  # glfw without a screen makes a context that is none
            raise MissingExtraError(
                f"no picture: OpenGL cannot draw without a screen here ({error}); install libegl1 or libosmesa6, "
                "set MUJOCO_GL to egl or osmesa, or leave the picture out"
            ) from error
        mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN.value, self._gl)
        self._scene = mj.MjvScene(bench.model, maxgeom=500)
        self._option, self._perturbation = mj.MjvOption(), mj.MjvPerturb()
        self._view = mj.MjvCamera()
        self._view.elevation = self._camera.elevation_deg
        self._view.distance = self._camera.distance_m

    def take(self, bench: Bench) -> NDArray[np.uint8]:
        """Return a picture of the bench as it is now, shape (height, width, 3); closed switches are red."""
        mj = self._mj
        colour_switches(bench)
        # The camera goes with the carriage, so that every grasp is seen from the same side of the hand.
        place = bench.target
        turn, (x, y, z) = place["turn"], self._camera.look_at_m
        self._view.azimuth = self._camera.azimuth_deg + float(np.rad2deg(turn))
        self._view.lookat[:] = [
            place["reach"] + np.cos(turn) * x - np.sin(turn) * y,
            place["shift"] + np.sin(turn) * x + np.cos(turn) * y,
            z,
        ]
        mj.mjv_updateScene(
            bench.model, bench.data, self._option, self._perturbation, self._view,
            mj.mjtCatBit.mjCAT_ALL.value, self._scene,
        )  # fmt: skip
        frame = mj.MjrRect(0, 0, self._camera.width, self._camera.height)
        picture = np.empty((self._camera.height, self._camera.width, 3), dtype=np.uint8)
        mj.mjr_render(frame, self._scene, self._gl)
        mj.mjr_readPixels(picture, None, frame, self._gl)
        return picture[::-1].copy()

    def close(self) -> None:
        """Give the drawing context back."""
        self._gl.free()
        self._context.free()


def _context(width: int, height: int) -> Any:
    """Make a current OpenGL context that needs no screen; MUJOCO_GL chooses where it is set."""
    asked = os.environ.get("MUJOCO_GL", "").lower()
    reasons = []
    for backend in (asked,) if asked else _BACKENDS:
        try:
            context = importlib.import_module(f"mujoco.{backend}").GLContext(width, height)
            context.make_current()
        except Exception as error:  # each backend fails in its own way, some with bare Exception
            reasons.append(f"{backend}: {error}")
            # A backend that failed leaves its mark, which would forbid the next one.
            if not asked:
                os.environ.pop("PYOPENGL_PLATFORM", None)
        else:
            return context
    raise MissingExtraError(
        f"no picture: OpenGL cannot draw without a screen here ({'; '.join(reasons)}); install libegl1 or "
        "libosmesa6, set MUJOCO_GL to egl or osmesa, or leave the picture out"
    )


def tile(pictures: list[NDArray[np.uint8]], *, columns: int, gap: int = 6) -> NDArray[np.uint8]:
    """Put pictures of one size side by side on white, row by row.

    Examples
    --------
    >>> tile([np.zeros((4, 5, 3), np.uint8)] * 3, columns=2, gap=1).shape
    (11, 13, 3)
    """
    height, width = pictures[0].shape[:2]
    rows = -(-len(pictures) // columns)
    sheet = np.full((rows * (height + gap) + gap, columns * (width + gap) + gap, 3), 255, dtype=np.uint8)
    for k, picture in enumerate(pictures):
        top, left = gap + (k // columns) * (height + gap), gap + (k % columns) * (width + gap)
        sheet[top : top + height, left : left + width] = picture
    return sheet


def photograph(
    name: str,
    size_m: float,
    path: str | os.PathLike[str],
    *,
    seed: int,
    setting: HandSetting | None = None,
    pad_steps: tuple[int, ...] = (5,),
    camera: Camera | None = None,
) -> Grasp:
    """Grasp an object and write a picture of the steps of the last attempt, as in the paper's Fig. 6.

    Arguments and errors as in `grasp`, and:

    Parameters
    ----------
    path : str or path-like
        The picture (PNG).
    camera : Camera, optional

    Raises
    ------
    MissingExtraError
        If nothing here can draw without a screen.
    """
    taken: list[NDArray[np.uint8]] = []
    photographers: list[Photographer] = []

    def watch(bench: Bench, step: Step) -> None:
        if not photographers:
            photographers.append(Photographer(bench, camera))
        if step.number == 1:
            taken.clear()
        taken.append(photographers[0].take(bench))

    done = grasp(name, size_m, seed=seed, setting=setting, pad_steps=pad_steps, watch=watch)
    if not taken:
        raise InputError(f"no picture: the hand did not find the {name}; try another seed")
    photographers[0].close()
    with atomic_write(path) as file:
        file.write(png_bytes(tile(taken, columns=min(len(taken), 5))))
    return done
