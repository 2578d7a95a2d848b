"""Calibration by presses of anything: neighbours feel nearly the same, press after press."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, ndimage

from varishold._counted import counted
from varishold.calibration.agreement import LEAST_SPREAD, agreement_of, hardly_pressed
from varishold.calibration.readings import Presses, presses_of
from varishold.calibration.result import Calibration, Finding, error_of_spread
from varishold.calibration.silent import marked_broken, pressed_around, silent_taxels
from varishold.errors import InputError
from varishold.frame.bends import bends_of
from varishold.recording import Recording
from varishold.sensor import Sensor

__all__ = ["FEWEST_PRESSES", "LEAST_SPREAD", "calibrate_unlabelled"]

Floats = NDArray[np.float64]

# Presses whose cosine with their mean is above this on the median are all alike.
_SAME = 0.98

#: Presses below which no gain can be told from the form of what pressed.
FEWEST_PRESSES = 20

# A taxel takes part in a press where what surrounds it presses it, and it stands above so many sigma of the noise.
_SIGMAS = 4.0
# Presses in which a taxel that is broken stays silent: a ring leaves one alone that it goes around.
_FEWEST_TO_BREAK = 5
# Degrees of freedom of the residuals' distribution: edges and tips are far outliers.
_FREEDOM = 1.0
_ROUNDS = 10
# What forms have in common bends gains slowly over the pad, alike in both halves of the presses: on drawn presses gains
# are off by up to so many times what the halves and the fit tell.
_FORM = 1.3
# Share of the usable taxels that must be pressed, and from which on few enough are left out.
_LEAST_PRESSED, _WELL_PRESSED, _FEW = 0.5, 0.8, 50


def calibrate_unlabelled(
    recordings: Sequence[Recording], *, sensor: Sensor | None = None, pad: str | None = None
) -> Calibration:
    """Find the gains, as far as they can be known, from presses of anything.

    The logarithm of a reading is that of the pressure and that of the taxel's gain. Pressure is smooth
    nearly everywhere and its form changes from press to press, gains stay: second differences of log
    readings, weighed so that edges and tips count for little, are solved for the gains, with a prior that
    gains scatter about 1 as widely as is found. Taxels that were seldom pressed stay near 1.

    Parameters
    ----------
    recordings : sequence of Recording
        Presses of any things, at places all over the pad; 50 to 100 are good.
    sensor : Sensor, optional
        What is known already; its response is undone first.
    pad : str, optional
        Which pad of the recordings.

    Returns
    -------
    Calibration
        Gains that spread by less than `LEAST_SPREAD`, or that two halves of the presses do not
        agree on, are told and not applied.

    Raises
    ------
    InputError
        If there are fewer than `FEWEST_PRESSES` presses, they are all alike, or the rest moves.
    """
    known = sensor or Sensor()
    found = presses_of(recordings, known, pad=pad)
    if found.n < FEWEST_PRESSES:
        raise InputError(
            f"gains cannot be told from {counted(found.n, 'unlabelled press')}: {FEWEST_PRESSES} are the least, "
            "50 to 100 good; or press all taxels evenly, and calibrate from that",
            parameter="kind",
        )
    _check_differ(found)
    base = dataclasses.replace(known.upright(), gains=None, crosstalk=0.0, blur_taxels=0.0)
    stress = base.stress(found.frames)
    noise = found.noise * abs(base.least_stress(1.0))
    inside, broken = _inside(stress, noise, found.usable)
    gains, error = _solved(stress, noise, inside)
    halves = [_solved(stress[k::2], noise[k::2], inside[k::2])[0] for k in (0, 1)]
    pressed = inside.sum(axis=0) >= 3
    _check_reached(pressed | broken, found)
    told = (pressed & ~broken)[found.usable]
    agreed = agreement_of(*(half[found.usable][told] for half in halves))
    of_fit, error = error, _FORM * np.maximum(error, agreed.differ)
    applied = agreed.worth
    notes = _notes(found, broken, found.usable & ~pressed & ~broken)
    if not applied:
        notes.insert(0, agreed.refusal)
    elif known.gains is not None:
        notes.append("the gains that were known are left: these take their place")
    kept = np.ones(found.usable.shape) if known.gains is None else known.gains
    map_ = np.where(broken, 0.0, np.exp(gains - np.median(gains[found.usable])) if applied else kept)
    measured = np.where(found.usable, map_, 1.0) if applied or broken.any() else known.gains
    taken = gains if applied else np.zeros_like(gains)
    left, before = _roughness(stress, inside, taken), _roughness(stress, inside, np.zeros_like(gains))
    outcome = Calibration(
        kind="unlabelled",
        sensor=found.sensor_with(known, gains=measured),
        presses=found.n,
        findings=(
            Finding(
                "gain_spread",
                agreed.spread,
                error_of_spread(agreed.spread, agreed.differ, gains[found.usable][told], of_fit[found.usable][told]),
                f"how much the taxels' gains differ, as two halves of the presses agree; each is known to "
                f"{100 * float(np.median(error[pressed])) if pressed.any() else 100:.2g} %",
                share=True,
            ),
        ),
        unknown=(
            "the response: any curve of the readings explains presses of unknown things as well; use known objects, or "
            "an even pressure at three known pressures",
            "a slope or a bend of all gains over the pad, which forms look like: use an even pressure",
            "crosstalk, blur, dead band and the cover: use known objects",
        ),
        notes=(*found.notes, *notes),
        before=np.where(found.usable & pressed, np.exp(before), np.nan),
        after=np.where(found.usable & pressed & ~broken, np.exp(left), np.nan),
        error=np.where(found.usable & pressed & ~broken, error, np.nan),
        residual=_scatter(stress, inside, taken),
    )
    return outcome.recorded()


def _notes(found: Presses, broken: NDArray[np.bool_], silent: NDArray[np.bool_]) -> list[str]:
    """Say which taxels are broken, and which were hardly pressed."""
    notes = marked_broken(broken)
    if found.n < _FEW and np.count_nonzero(silent) > (1 - _WELL_PRESSED) * np.count_nonzero(found.usable):
        notes.append(
            f"{counted(found.n, 'press is', 'presses are')} few for this pad: {_FEW} to 100, all over it, are good"
        )
    return [*notes, *hardly_pressed(silent)]


def _check_differ(found: Presses) -> None:
    """Refuse presses that are all alike: what stays from press to press is then the thing as well as the gains."""
    flat = found.frames[:, found.usable]
    flat = flat / np.maximum(np.linalg.norm(flat, axis=1), 1e-300)[:, None]
    mean = flat.mean(axis=0)
    if float(np.median(flat @ mean)) > _SAME * float(np.linalg.norm(mean)):
        raise InputError(
            "the presses are all alike, so that the form of the thing and the gains cannot be told apart: press other "
            "things, at places all over the pad"
        )


def _check_reached(reached: NDArray[np.bool_], found: Presses) -> None:
    """Refuse presses that leave much of the pad without a gain."""
    n, of = np.count_nonzero(reached & found.usable), np.count_nonzero(found.usable)
    if n < _LEAST_PRESSED * of:
        raise InputError(
            f"{counted(found.n, 'unlabelled press presses', 'unlabelled presses press')} "
            f"only {n} of {of} taxels three times or more: press more, all over the "
            "pad; 50 to 100 presses are good",
            parameter="kind",
        )


def _inside(stress: Floats, noise: Floats, usable: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return where each press presses, and the taxels that feel nothing of it."""
    pressed = pressed_around(stress, usable)
    broken = silent_taxels(stress, usable, pressed, fewest=_FEWEST_TO_BREAK)
    inside = pressed[1] & usable & ~broken & (stress > _SIGMAS * noise[:, None, None])
    return inside, broken


def _solved(stress: Floats, noise: Floats, inside: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return the log gains that explain second differences best, and their standard errors."""
    shape = (stress.shape[1], stress.shape[2])
    size = shape[0] * shape[1]
    bends = bends_of(stress, inside, noise)
    gains: Floats = np.zeros(shape)
    spread: Floats = np.zeros(shape)
    scatter = 0.25
    for _ in range(_ROUNDS):
        normal, right = np.eye(size) / scatter**2, np.zeros(shape)
        for bend in bends:
            weighed = bend.weighed(gains, _FREEDOM)
            weighed.add_right(right)
            normal += weighed.matrix(shape)
        root = linalg.cholesky(normal, lower=True)
        gains = linalg.cho_solve((root, True), right.ravel()).reshape(shape)
        # The diagonal of the inverse, without the rest of it.
        inverse_root, _ = linalg.lapack.dtrtri(root, lower=True)
        spread = np.linalg.norm(inverse_root, axis=0).reshape(shape)
        scatter = max(float(np.sqrt(np.mean(gains**2 + spread**2))), 1e-4)
    return gains, spread


def _beside(stress: Floats, inside: NDArray[np.bool_], gains: Floats) -> Floats:
    """Return each log stress beside the mean of its neighbours inside; NaN where there are fewer than three."""
    log = np.log(np.where(inside, stress, 1.0)) - gains
    kernel = np.array([[[0.0, 1, 0], [1, 0, 1], [0, 1, 0]]])
    count = ndimage.convolve(inside.astype(np.float64), kernel, mode="constant")
    total = ndimage.convolve(np.where(inside, log, 0.0), kernel, mode="constant")
    return np.where(inside & (count >= 3), log - total / np.maximum(count, 1.0), np.nan)


def _roughness(stress: Floats, inside: NDArray[np.bool_], gains: Floats) -> Floats:
    """Return by how much each taxel usually reads more than its neighbours, as a logarithm."""
    beside = _beside(stress, inside, gains)
    there = np.isfinite(beside).any(axis=0)
    median = np.zeros(stress.shape[1:])
    median[there] = np.nanmedian(beside[:, there], axis=0)
    return median - float(np.median(median[there])) if there.any() else median


def _scatter(stress: Floats, inside: NDArray[np.bool_], gains: Floats) -> Floats:
    """Return how far each taxel scatters about its neighbours from press to press."""
    beside = _beside(stress, inside, gains)
    there = np.isfinite(beside).sum(axis=0) >= 3
    scatter = np.full(stress.shape[1:], np.nan)
    scatter[there] = np.nanmedian(np.abs(beside[:, there]), axis=0)
    return scatter
