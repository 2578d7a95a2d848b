"""The receptor: stress in, pulses out, and the variable threshold that turns it into sections.

Each taxel drives one unit of the paper's Fig. 2: a potential that leaks and integrates, a threshold that
varies, and an output function. Three kinds are offered by the names of the skin's own afferents. The slowly
adapting one (SA) holds a static pressure, and its sections are what VARISHOLD cuts; the rapidly adapting
(RA) and the Pacinian one (PC), which the paper names, answer to change only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import lfilter

from varishold.errors import InputError
from varishold.frame.checks import as_positive

__all__ = [
    "RECEPTORS",
    "FiredSections",
    "Output",
    "Receptor",
    "potential",
    "pulse_rate",
    "pulses",
    "unit_output",
    "varishold_sections",
]

Floats = NDArray[np.float64]
Output = Literal["step", "amplitude", "pulse rate"]

# Potentials are within 1 % of their end after so many time constants.
_SETTLED = 5.0


@dataclass(frozen=True)
class Receptor:
    """Constants of one kind of receptor; stress is in shares of full scale, times in seconds.

    Parameters
    ----------
    channel : {"SA", "RA", "PC"}
        Slowly adapting, rapidly adapting, Pacinian.
    depth_m : float
        Where such endings lie in skin, metres.
    tau_m_s : float
        Time constant of the potential.
    tau_a_s, adaptation : float
        Time constant of slow adaptation, and the share of the adapted stress that SA subtracts.
    rate_gain_s, velocity_gain_s, acceleration_gain_s2 : float
        Gains k_d, k_v, k_a of the drives on the stress's first and second derivative.
    velocity_poles_hz : float
        Both poles of the low-pass before RA's drive.
    ceiling : float
        x_max, which a drive approaches and never passes.
    threshold : float
        theta_0, the resting threshold.
    rises, tau_h_s : (float, float)
        By how much each pulse raises the threshold, and the two time constants with which it falls back.
    refractory_s : float
        Shortest time between two pulses.

    References
    ----------
    R. Kobayashi, Y. Tsubo and S. Shinomoto, "Made-to-order spiking neuron model equipped with a
    multi-timescale adaptive threshold", Front. Comput. Neurosci. 3, 2009. H. P. Saal, B. P. Delhaye,
    B. C. Rayhaun and S. J. Bensmaia, "Simulating tactile signals from the whole hand with millisecond
    precision", PNAS 114, 2017.
    """

    channel: Literal["SA", "RA", "PC"]
    depth_m: float
    tau_m_s: float
    tau_a_s: float = 1.7
    adaptation: float = 0.45
    rate_gain_s: float = 0.02
    velocity_gain_s: float = 0.03
    acceleration_gain_s2: float = 4e-5
    velocity_poles_hz: float = 60.0
    ceiling: float = 3.0
    threshold: float = 0.1
    rises: tuple[float, float] = (0.35, 0.08)
    tau_h_s: tuple[float, float] = (10e-3, 200e-3)
    refractory_s: float = 2e-3


#: Receptors by the names that a skin file takes.
RECEPTORS: dict[str, Receptor] = {
    "SA": Receptor("SA", depth_m=0.3e-3, tau_m_s=30e-3),
    "RA": Receptor("RA", depth_m=1.6e-3, tau_m_s=8e-3),
    "PC": Receptor("PC", depth_m=2.0e-3, tau_m_s=1.5e-3),
}


@dataclass(frozen=True)
class FiredSections:
    """What a falling threshold makes of a pad: X_1 ... X_n as binary frames.

    Parameters
    ----------
    thresholds : ndarray of shape (n,), float64
        theta_1 > ... > theta_n, in the unit of the stress.
    fired : ndarray of shape (n, rows, cols), bool
        X_i: the taxels whose potential exceeds theta_i. Each holds the one before it.
    first : ndarray of shape (rows, cols), int64
        Index of the threshold at which a taxel first fired; n where it never did.
    """

    thresholds: Floats
    fired: NDArray[np.bool_]
    first: NDArray[np.int64]

    def rebuilt(self) -> Floats:
        """Return the stress as the sections know it, sum of X_i dtheta_i: right to the largest step.

        Returns
        -------
        ndarray of shape (rows, cols), float64
        """
        steps = -np.diff(self.thresholds, append=0.0)
        return np.tensordot(steps, self.fired.astype(np.float64), axes=1)

    def bits(self, *, coding: Literal["raster", "events"] = "events") -> int:
        """Return how many bits carry the sections off the pad.

        Parameters
        ----------
        coding : {"raster", "events"}
            A bit a taxel and threshold, or the address of each taxel when it first fires and an end
            mark for each threshold.

        Returns
        -------
        int
        """
        count, taxels = len(self.thresholds), self.first.size
        if coding == "raster":
            return count * taxels
        fired = int(np.count_nonzero(self.first < count))
        # One address more than there are taxels stands for "next threshold".
        return (fired + count) * int(np.ceil(np.log2(taxels + 1)))


def potential(stress: ArrayLike, receptor: Receptor, *, step_s: float, full_scale: float = 1.0) -> Floats:
    """Return the inner potential I over time (R1-R4).

    Parameters
    ----------
    stress : array_like of shape (n, ...)
        Stress history; the pad is at rest, at zero, before it.
    receptor : Receptor
        The kind, as in `RECEPTORS`.
    step_s : float
        Time between two entries, seconds.
    full_scale : float
        Stress that counts as 1.

    Returns
    -------
    ndarray of the same shape, float64

    Raises
    ------
    InputError
        If the history has no time axis, or a time or a scale is not positive.
    """
    s = np.asarray(stress, dtype=np.float64) / as_positive(full_scale, "full_scale")
    if s.ndim < 1 or s.shape[0] < 1:
        raise InputError(f"stress must be a history of shape (n, ...), got shape {s.shape}")
    step = as_positive(step_s, "step_s")
    rate = np.diff(s, axis=0, prepend=np.zeros_like(s[:1])) / step
    if receptor.channel == "SA":
        adapted = _smoothed(s, step, receptor.tau_a_s)
        drive = np.maximum(s - receptor.adaptation * adapted, 0) + receptor.rate_gain_s * np.maximum(rate, 0)
    elif receptor.channel == "RA":
        tau = 1 / (2 * np.pi * receptor.velocity_poles_hz)
        drive = receptor.velocity_gain_s * np.abs(_smoothed(_smoothed(rate, step, tau), step, tau))
    else:
        change = np.diff(rate, axis=0, prepend=np.zeros_like(rate[:1])) / step
        drive = receptor.acceleration_gain_s2 * np.abs(change)
    return _smoothed(_compressed(drive, receptor), step, receptor.tau_m_s)


def pulses(inner: ArrayLike, receptor: Receptor, *, step_s: float) -> NDArray[np.bool_]:
    """Return where units fire (R5-R6): above a threshold that every pulse raises and time lowers.

    The potential is not reset by a pulse but goes on integrating: the paper's reintegration, in one reading.

    Parameters
    ----------
    inner : array_like of shape (n, ...)
        Inner potential, from `potential`.
    receptor : Receptor
        The kind.
    step_s : float
        Time between two entries, seconds.

    Returns
    -------
    ndarray of the same shape, bool
    """
    inner = np.asarray(inner, dtype=np.float64)
    step = as_positive(step_s, "step_s")
    fall = [np.exp(-step / tau) for tau in receptor.tau_h_s]
    rest = max(1, round(receptor.refractory_s / step))
    raised = [np.zeros(inner.shape[1:]) for _ in fall]
    since = np.full(inner.shape[1:], rest)
    out = np.zeros(inner.shape, dtype=bool)
    for n in range(inner.shape[0]):
        for h, factor in zip(raised, fall, strict=True):
            h *= factor
        fire = (inner[n] > receptor.threshold + sum(raised)) & (since >= rest)
        out[n] = fire
        since = np.where(fire, 1, since + 1)
        for h, rise in zip(raised, receptor.rises, strict=True):
            h += rise * fire
    return out


def pulse_rate(fired: ArrayLike, *, step_s: float, window_s: float = 0.1) -> Floats:
    """Return pulses a second over the last `window_s`, shape as `fired`."""
    fired = np.asarray(fired, dtype=np.float64)
    count = max(1, round(as_positive(window_s, "window_s") / as_positive(step_s, "step_s")))
    total = np.cumsum(fired, axis=0)
    before = np.concatenate([np.zeros_like(total[:count]), total])[: total.shape[0]]
    out: Floats = (total - before) / (count * step_s)
    return out


def unit_output(
    inner: ArrayLike,
    threshold: float | ArrayLike,
    output: Output,
    *,
    receptor: Receptor | None = None,
    step_s: float | None = None,
) -> Floats:
    """Return the output of the paper's threshold unit, whose function generator it leaves open.

    Parameters
    ----------
    inner : array_like of shape (n, ...)
        Inner potential.
    threshold : float or array_like
        Threshold for "step" and "amplitude"; an array broadcasts against `inner`.
    output : {"step", "amplitude", "pulse rate"}
        1 above the threshold, what exceeds it, or pulses a second of `pulses`.
    receptor, step_s
        For "pulse rate": the kind, with its own threshold raised to `threshold`, and the time step.

    Returns
    -------
    ndarray of the shape of `inner`, float64

    Raises
    ------
    InputError
        If the output is unknown, or the pulse rate lacks a receptor or a time step.
    """
    inner = np.asarray(inner, dtype=np.float64)
    if output not in get_args(Output):
        raise InputError(f"output must be one of {', '.join(get_args(Output))}, got {output!r}")
    if output == "step":
        return (inner > threshold).astype(np.float64)
    if output == "amplitude":
        exceeding: Floats = np.maximum(inner - np.asarray(threshold, dtype=np.float64), 0.0)
        return exceeding
    if receptor is None or step_s is None:
        raise InputError("the pulse rate needs receptor and step_s")
    above = inner - (np.asarray(threshold, dtype=np.float64) - receptor.threshold)
    return pulse_rate(pulses(above, receptor, step_s=step_s), step_s=step_s)


def varishold_sections(
    frame: ArrayLike,
    thresholds: int | Sequence[float] | Floats,
    *,
    receptor: Receptor = RECEPTORS["SA"],
    step_s: float = 1e-3,
    full_scale: float | None = None,
    settle: bool = True,
) -> FiredSections:
    """Hold a stress, let the threshold fall step by step, and note which units exceed it (R7).

    Adaptation and pulse history are off: a static pressure stays. Potentials are given five time constants
    to settle; without that each threshold is lowered by what a potential has reached by then.

    Parameters
    ----------
    frame : array_like of shape (rows, cols)
        Stress over each taxel.
    thresholds : int or sequence of float
        Falling thresholds in the unit of the stress; a number of them: evenly, at half steps from the full scale down.
    receptor : Receptor
        A slowly adapting kind: the others cannot hold a pressure.
    step_s : float
        Time a threshold stands, seconds.
    full_scale : float, optional
        Stress that counts as 1; default: the frame's peak.
    settle : bool
        Whether to wait until the potentials have settled.

    Returns
    -------
    FiredSections

    Raises
    ------
    InputError
        If the receptor does not hold, the frame has not two dimensions, or the thresholds do not fall.

    Examples
    --------
    >>> sections = varishold_sections([[0.0, 1.0], [2.0, 4.0]], 4)
    >>> sections.thresholds
    array([3.5, 2.5, 1.5, 0.5])
    >>> sections.fired.sum(axis=(1, 2))
    array([1, 1, 2, 3])
    """
    given = np.asarray(frame, dtype=np.float64)
    if given.ndim != 2:
        raise InputError(f"frame must have shape (rows, cols), got {given.shape}")
    if receptor.channel != "SA":
        raise InputError(f"a {receptor.channel} receptor cannot hold a static pressure; use SA")
    scale = float(given.max()) if full_scale is None else float(full_scale)
    # Below the least normal number there is no room for thresholds: such a frame is at rest.
    scale = as_positive(scale if scale >= np.finfo(float).tiny or full_scale is not None else 1.0, "full_scale")
    if isinstance(thresholds, int | np.integer):
        count = int(thresholds)
        theta = scale * (1 - (np.arange(count) + 0.5) / max(count, 1))
    else:
        theta = np.asarray(thresholds, dtype=np.float64)
    if theta.ndim != 1 or theta.size < 1 or not (np.diff(theta) < 0).all():
        raise InputError(f"thresholds must be one or more falling values, got {np.array2string(theta)}")
    drive = _compressed(np.maximum(given, 0.0) / scale, receptor)
    level = _compressed(np.maximum(theta, 0.0) / scale, receptor)
    step = as_positive(step_s, "step_s")
    waited = int(np.ceil(_SETTLED * receptor.tau_m_s / step)) if settle else 0
    time = (waited + 1 + np.arange(theta.size)) * step
    reached = 1 - np.exp(-time / receptor.tau_m_s)
    if not settle:
        level = level * reached
    fired = drive[None] * reached[:, None, None] > level[:, None, None]
    # A unit that has fired stays noted: potentials only rise while the stress is held.
    fired = np.logical_or.accumulate(fired, axis=0)
    return FiredSections(theta, fired, (~fired).sum(axis=0))


def _smoothed(values: Floats, step_s: float, tau_s: float) -> Floats:
    """First-order lag: y <- y + (x - y) (1 - exp(-step / tau)), from rest."""
    keep = np.exp(-step_s / tau_s)
    return lfilter([1 - keep], [1.0, -keep], values, axis=0)


def _compressed(drive: Floats, receptor: Receptor) -> Floats:
    return drive / (1 + drive / receptor.ceiling)
