"""A library for pads whose taxels are poorer than those that it was learned with.

How far each number of a pad scatters under given taxels is not guessed: touches that were felt by ideal taxels are felt
again by the given ones, and what that changes is added, at random among like presses, to every example of the library.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from varishold.errors import InputError, require
from varishold.files import open_archive
from varishold.perceive.evidence import form_values, pad_values
from varishold.perceive.left_out import metrics_without
from varishold.perceive.library import Library
from varishold.perceive.metric import Metric, fit_metric
from varishold.perceive.touch_model import TouchModel, with_scores
from varishold.skin import Skin, Taxels
from varishold.touch import feel_surface

__all__ = ["for_pads"]

Floats = NDArray[np.float64]

_TOUCHES = Path(__file__).with_name("pad_touches.npz")
#: Noise of the pads that the shipped library was learned with, as a share of the peak.
_USUAL = Taxels(noise=0.01)
# The touches are felt by so many pads of the given kind, and what they change is drawn among so many like presses.
_PADS, _ALIKE = 3, 12
# Pads that feel less than this share of presses tell nothing.
_LEAST_FELT = 0.5
# What a pad says begins so; what all of them say together are these.
_PAD, _FORMS = "pad.", ("form.pads_round", "form.least_round")
_ON = "on"
# A number that all presses share says nothing of likeness.
_LEAST_SPREAD = 1e-6


@dataclass(frozen=True, eq=False)
class _Changes:
    """What numbers become under other taxels: a row a press (or a touch), a column a number of `names`."""

    names: tuple[str, ...]
    usual: Floats
    poor: Floats

    def applied(self, values: Floats, rng: np.random.Generator) -> Floats:
        """Change each row as one of the presses was changed that are most like it."""
        scale = np.maximum(self.usual.std(axis=0), _LEAST_SPREAD)
        _, near = cKDTree(self.usual / scale).query(values / scale, k=min(_ALIKE, len(self.usual)))
        near = near.reshape(len(values), -1)
        chosen = near[np.arange(len(values)), rng.integers(near.shape[1], size=len(values))]
        changed: Floats = values + self.poor[chosen] - self.usual[chosen]
        if _ON in self.names:
            # What the other taxels do not feel at all reads as every pad does on which nothing lies.
            changed[self.poor[chosen, self.names.index(_ON)] == 0] = 0.0
        return changed


def for_pads(
    library: Library, taxels: Taxels, *, seed: int = 0, progress: Callable[[int, int], None] | None = None
) -> Library:
    """Return a library whose likelihoods know what kind of taxels the pads have.

    Known objects are then not refused because taxels are bad. What is known of a sensor is undone before its frames are
    felt (`varishold.sensor`); here belongs what remains: noise, gains that nobody has measured, dead taxels that nobody
    has marked, crosstalk.

    Parameters
    ----------
    library : Library
        Learned with good taxels (1 % noise), as the shipped one. Numbers of pads are those that `pad_values` and
        `form_values` name; all other numbers stay as they are.
    taxels : Taxels
        The pads' taxels.
    seed : int
        The same seed gives the same library.
    progress : callable, optional
        Called with how many touches were felt, and of how many: some ten seconds in all.

    Returns
    -------
    Library

    Raises
    ------
    InputError
        If the taxels are none or feel hardly anything, a seed is negative, or no touch of the library knows a pad.

    Examples
    --------
    >>> from varishold.perceive import Perceiver, shipped_library
    >>> from varishold.skin import Taxels
    >>> poor = for_pads(shipped_library(), Taxels(noise=0.03, gain_spread=0.15, dead=0.03))  # doctest: +SKIP
    >>> perceiver = Perceiver(poor)  # doctest: +SKIP
    """
    require(isinstance(taxels, Taxels), f"taxels must be a varishold.skin.Taxels, got {taxels!r}")
    require(isinstance(seed, int) and seed >= 0, f"seed must be a whole number from 0 on, got {seed!r}")
    if not any(name.startswith(_PAD) for model in library.touches.values() for name in model.metric.names):
        raise InputError("no touch of the library knows a pad, so that taxels change nothing")
    pads, forms = _changes(taxels, seed, progress or (lambda done, of: None))
    rng = np.random.default_rng([seed, 3])
    return replace(
        library,
        touches={touch: _changed(model, library, pads, forms, rng) for touch, model in library.touches.items()},
    )


def _changed(
    model: TouchModel, library: Library, pads: _Changes, forms: _Changes, rng: np.random.Generator
) -> TouchModel:
    names = model.metric.names
    if not any(name.startswith(_PAD) for name in names):
        return model
    values, others = (_felt_again(names, each, pads, forms, rng) for each in (model.values, model.others))
    rows = model.made & library.usual if (model.made & library.usual).any() else model.made
    metric = _scattering_more(model, values[rows], library, rows)
    # Conformity and power are told anew; the kernel stays. Of what is felt now its scatter was learned, if anything.
    changed = replace(model, metric=metric, values=values, others=others, optimism=None)
    judged = None
    if model.optimism is None:
        judged = metrics_without(metric, values, library.kind, library.log_size, learned_from=rows)
    return with_scores(changed, library.kind, judged)


def _scattering_more(model: TouchModel, values: Floats, library: Library, rows: NDArray[np.bool_]) -> Metric:
    """Return the metric of changed values (of these rows): what they scatter more within objects is added to it."""
    of, sizes, names = library.kind[rows], library.log_size[rows], model.metric.names
    again = fit_metric(names, values, of, sizes)
    if model.optimism is None:
        return again
    before = fit_metric(names, model.values[rows], of, sizes)
    # In the units of the metric that was learned; a number that scatters less counts no more for it.
    per_unit = again.scale / model.metric.scale, before.scale / model.metric.scale
    more = (
        np.outer(per_unit[0], per_unit[0]) * again.covariance - np.outer(per_unit[1], per_unit[1]) * before.covariance
    )
    values_of, vectors = np.linalg.eigh(more)
    added = (vectors * np.maximum(values_of, 0.0)) @ vectors.T
    return replace(model.metric, covariance=model.metric.covariance + added)


def _felt_again(
    names: tuple[str, ...], values: Floats, pads: _Changes, forms: _Changes, rng: np.random.Generator
) -> Floats:
    out = values.copy()
    for of, columns in _columns(names, pads.names, forms.names):
        whole = np.isfinite(values[:, columns]).all(axis=1)
        if of is pads.names:
            whole &= values[:, columns[pads.names.index(_ON)]] > 0
        rows = np.flatnonzero(whole)
        if len(rows):
            changes = pads if of is pads.names else forms
            out[rows[:, None], columns] = changes.applied(values[rows[:, None], columns], rng)
    return out


def _columns(
    names: tuple[str, ...], pad: tuple[str, ...], forms: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], list[int]]]:
    """Yield the columns of every pad whose numbers are all there, and of what all pads say together."""
    at = {name: k for k, name in enumerate(names)}
    parts = dict.fromkeys(name.rsplit(".", 1)[0] for name in names if name.startswith(_PAD))
    for own, of in [*((f"{part}.", pad) for part in parts), ("", forms)]:
        if all(own + name in at for name in of):
            yield of, [at[own + name] for name in of]


def _changes(taxels: Taxels, seed: int, progress: Callable[[int, int], None]) -> tuple[_Changes, _Changes]:
    """What the given taxels change of pads' numbers, and of what all pads say together."""
    presses: list[tuple[Mapping[str, float], Mapping[str, float]]] = []
    forms: list[tuple[Mapping[str, float], Mapping[str, float]]] = []
    touches = _touches()
    for k, touch in enumerate(touches):
        first = 1_000_000 * seed + 1000 * k
        usual, all_usual = touch.felt(_USUAL, first)
        for pads in range(1, 1 + _PADS):
            poor, all_poor = touch.felt(taxels, first + 100 * pads)
            presses += [(u, p) for u, p in zip(usual, poor, strict=True) if u[_ON]]
            if all_usual and all_poor:
                forms.append((all_usual, all_poor))
        progress(k + 1, len(touches))
    felt = sum(poor[_ON] for _, poor in presses)
    require(felt > _LEAST_FELT * len(presses), f"such taxels feel {felt:.0f} of {len(presses)} presses: too few")
    return _side_by_side(presses), _side_by_side(forms)


def _side_by_side(pairs: list[tuple[Mapping[str, float], Mapping[str, float]]]) -> _Changes:
    names = tuple(pairs[0][0])
    usual, poor = (np.array([[each[k][name] for name in names] for each in pairs]) for k in (0, 1))
    return _Changes(names, usual, poor)


@dataclass(frozen=True, eq=False)
class _Touch:
    """The frames of the pressed pads of one touch, as ideal taxels felt them."""

    frames: tuple[Floats, ...]
    pitches_m: tuple[float, ...]
    size_m: float | None
    skin: Skin

    def felt(self, taxels: Taxels, seed: int) -> tuple[list[dict[str, float]], dict[str, float]]:
        """Return what these taxels say of each pad, and of all together."""
        surfaces = {
            str(k): feel_surface(taxels.read(frame, seed=seed + k), self.skin, pitch_m=pitch_m)
            for k, (frame, pitch_m) in enumerate(zip(self.frames, self.pitches_m, strict=True))
        }
        pads = [pad_values(name, surface, size_m=self.size_m) for name, surface in surfaces.items()]
        return [{name.rsplit(".", 1)[1]: value for name, value in pad.items()} for pad in pads], form_values(
            None, surfaces
        )


@cache
def _touches() -> tuple[_Touch, ...]:
    with open_archive(_TOUCHES) as file:
        kept = {name: file.array(name) for name in file.names}
    thickness_m, poisson, sensing_depth_m, modulus = kept["skin"].tolist()
    skin = Skin(
        "layer", thickness_m=thickness_m, poisson=poisson, sensing_depth_m=sensing_depth_m, youngs_modulus_pa=modulus
    )
    ends = np.cumsum(kept["shape"].astype(np.int64).prod(axis=1))
    frames = [
        part.reshape(shape) / 255.0 * float(peak)
        for part, shape, peak in zip(np.split(kept["levels"], ends[:-1]), kept["shape"], kept["peak"], strict=True)
    ]
    touches = []
    for k, size in enumerate(kept["size_m"].tolist()):
        own = np.flatnonzero(kept["touch"] == k)
        pitches = tuple(float(kept["pitch_m"][j]) for j in own)
        touches.append(_Touch(tuple(frames[j] for j in own), pitches, size if size > 0 else None, skin))
    return tuple(touches)
