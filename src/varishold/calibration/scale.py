"""Calibration by small tips on a scale: the total is known, and few taxels share it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.calibration.readings import presses_of
from varishold.calibration.result import Calibration, Finding, error_of_spread
from varishold.errors import InputError
from varishold.recording import Recording
from varishold.sensor import Sensor

__all__ = ["BROADEST_TIP", "calibrate_scale"]

Floats = NDArray[np.float64]

#: Taxels that a press may share its force among: of a broader one the total says nothing of a single taxel.
BROADEST_TIP = 6.0
_FEWEST_PRESSES = 100
# Forces that differ by more than this must go with what the presses bear at least so well (correlation of logarithms).
_DIFFERENT, _TOGETHER = 0.1, 0.2
# Spread of the gains that is expected before anything is known.
_PRIOR = 0.25


def calibrate_scale(
    recordings: Sequence[Recording],
    *,
    force_n: ArrayLike | None,
    sensor: Sensor | None = None,
    pad: str | None = None,
) -> Calibration:
    """Find gains from presses of a small tip whose forces a scale has told.

    Force is the sum over the taxels of reading over gain, solved for 1 / gain with a prior that
    gains scatter about 1.

    Parameters
    ----------
    recordings : sequence of Recording
        Presses of a tip of a few taxels, all over the pad.
    force_n : array_like of shape (n_presses,)
        Force of each press, newton.
    sensor : Sensor, optional
        What is known already; its response is undone first.
    pad : str, optional
        Which pad of the recordings.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If presses are broad, too few, or `force_n` is missing, or does not go with what they bear.
    """
    known = sensor or Sensor()
    found = presses_of(recordings, known, pad=pad)
    base = dataclasses.replace(known.upright(), gains=None, crosstalk=0.0, blur_taxels=0.0)
    stress = np.where(found.usable, base.stress(found.frames), 0.0)
    positive = np.maximum(stress, 0.0)
    sharing = positive.sum(axis=(1, 2)) ** 2 / np.maximum((positive**2).sum(axis=(1, 2)), 1e-300)
    broad = float(np.median(sharing))
    if broad > BROADEST_TIP:
        raise InputError(
            f"broad presses on a scale do not identify gains: each is shared by about {broad:.0f} taxels, "
            f"at most {BROADEST_TIP:.0f} would do; press with a small tip, or calibrate from an even pressure "
            "or unlabelled presses",
            parameter="kind",
        )
    told = np.empty(0) if force_n is None else np.asarray(force_n, dtype=np.float64).ravel()
    if told.size != found.n or not np.all(np.isfinite(told) & (told > 0)):
        raise InputError(
            f"a scale tells the force of every press: force_n must be one positive number for each of the {found.n} "
            f"presses found, got {told.size}",
            parameter="force_n",
        )
    if found.n < _FEWEST_PRESSES:
        raise InputError(
            f"gains cannot be told from {found.n} presses of a tip: {_FEWEST_PRESSES} are the least, "
            "300 all over the pad good"
        )
    _check_together(np.log(np.maximum(positive.sum(axis=(1, 2)), 1e-300)), np.log(told))
    gains, error, seen = _solved(stress[:, found.usable], told)
    halves = [_solved(stress[k::2][:, found.usable], told[k::2])[0] for k in (0, 1)]
    spread = float(np.std(gains[seen]))
    spread_error = float(np.std(halves[0][seen] - halves[1][seen]) / 2)
    map_, errors, pressed = (
        np.ones(found.usable.shape),
        np.full(found.usable.shape, np.nan),
        np.zeros_like(found.usable),
    )
    map_[found.usable], errors[found.usable], pressed[found.usable] = gains, np.maximum(error, spread_error), seen
    left = ((stress / map_).sum(axis=(1, 2)) / told) / np.median((stress / map_).sum(axis=(1, 2)) / told) - 1
    share = positive / np.maximum(positive.sum(axis=(1, 2), keepdims=True), 1e-300)
    before = stress.sum(axis=(1, 2)) / told
    outcome = Calibration(
        kind="scale",
        sensor=found.sensor_with(known, gains=map_),
        presses=found.n,
        findings=(
            Finding(
                "gain_spread",
                spread,
                error_of_spread(spread, spread_error, gains[seen] - gains[seen].mean(), error[seen]),
                f"how much the taxels' gains differ; each is known to {100 * float(np.median(errors[pressed])):.2g} %",
                True,
            ),
        ),
        unknown=("the response, crosstalk, blur and the cover: use known objects",),
        notes=found.notes,
        before=np.where(pressed, np.tensordot(before / np.median(before), share, 1) / share.sum(axis=0), np.nan),
        after=np.where(pressed, 1 + np.tensordot(left, share, 1) / np.maximum(share.sum(axis=0), 1e-300), np.nan),
        error=np.where(pressed, errors, np.nan),
        residual=np.where(
            pressed, np.sqrt(np.tensordot(left**2, share, 1) / np.maximum(share.sum(axis=0), 1e-300)), np.nan
        ),
    )
    return outcome.recorded()


def _check_together(load: Floats, force: Floats) -> None:
    """Refuse forces of other presses: they differ, and presses of larger ones bear no more."""
    if np.std(force) > _DIFFERENT and np.std(load) > 0:
        together = float(np.corrcoef(load, force)[0, 1])
        if together < _TOGETHER:
            raise InputError(
                f"the forces are not those of the presses: where they are larger the pad reads no more (correlation "
                f"{together:.2f}); give each press its own, in the order in which they were recorded",
                parameter="force_n",
            )


def _solved(stress: Floats, force_n: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return gains, their standard errors, and which taxels were pressed at all."""
    rows = stress / force_n[:, None]
    # Counts a newton of the usual taxel: the total that most presses agree on.
    rows = rows / np.median(rows.sum(axis=1))
    size = stress.shape[1]
    noise, scatter = 0.05, _PRIOR
    inverse, spread = np.ones(size), np.full(size, scatter)
    for _ in range(8):
        covariance = np.linalg.inv(rows.T @ rows / noise**2 + np.eye(size) / scatter**2)
        inverse = covariance @ (rows.T @ np.ones(len(rows)) / noise**2 + np.ones(size) / scatter**2)
        spread = np.sqrt(np.diag(covariance))
        known = max(size - float(np.sum(spread**2)) / scatter**2, 0.0)
        noise = max(float(np.sqrt(np.sum((rows @ inverse - 1) ** 2) / max(len(rows) - known, 1.0))), 1e-3)
        scatter = max(float(np.sqrt(np.mean((inverse - 1) ** 2 + spread**2))), 1e-3)
    gains = 1.0 / np.maximum(inverse, 0.05)
    gains = gains / np.median(gains)
    return gains, spread * gains, np.asarray(spread < 0.9 * scatter)
