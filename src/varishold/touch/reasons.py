"""Why touch says what it says: what was measured, and which measures decided."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold.touch.decision import Parameters, kind_logits
from varishold.touch.names import KINDS
from varishold.touch.signature import SIGNATURE_GROUPS

if TYPE_CHECKING:
    from varishold.touch.surface import Surface

__all__ = ["evidence", "reasons_for"]

# A contact of fewer taxels than this has hardly an outline.
_FEW_TAXELS = 16.0
_GROUPS: tuple[str, ...] = tuple(dict.fromkeys(SIGNATURE_GROUPS))


def evidence(inputs: NDArray[np.float64], parameters: Parameters, kind: int, rival: int) -> dict[str, float]:
    """Return how much each group of measures speaks for `kind` against `rival`.

    Each group's measures are replaced by the rival's usual ones; what the log-odds lose by it is the
    group's weight in this decision.

    Parameters
    ----------
    inputs : ndarray of shape (n_inputs,), float64
        Whitened inputs of one contact.
    parameters : Parameters
        The learned table that decided.
    kind, rival : int
        Indices into `KINDS`.

    Returns
    -------
    dict of str to float
        Nats by group, largest first.
    """
    whole = kind_logits(inputs, parameters)
    odds = whole[kind] - whole[rival]
    groups = np.array(SIGNATURE_GROUPS)
    if len(inputs) == 2 * len(groups):
        groups = np.concatenate([groups, groups])
    found = {}
    for group in _GROUPS:
        other = np.where(groups == group, parameters.kind_means[rival], inputs)
        logits = kind_logits(np.ascontiguousarray(other), parameters)
        found[group] = float(odds - (logits[kind] - logits[rival]))
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def reasons_for(surface: Surface) -> tuple[str, ...]:
    """Return the reasons for a surface's name, the most telling first."""
    return (*_measured(surface), *_decided(surface), *_cautions(surface))


def _measured(surface: Surface) -> list[str]:
    profile = surface.contact.profile
    used = np.flatnonzero(profile.area >= 4 * surface.contact.taxel_area)
    said = []
    if len(used) >= 2:
        said.append(_growth(surface, used))
    section_p = sum(
        p for p, kind in zip(surface.kind_probability, KINDS, strict=True) if kind.section == surface.section
    )
    if surface.section == "field":
        field = int(np.isfinite(surface.contact.values).sum())
        share = surface.contact.n_taxels / max(field, 1)
        said.append(f"the contact covers {share:.0%} of the field")
    elif surface.section != "unknown":
        said.append(f"outline {surface.section} ({section_p:.2f})")
    return said


def _growth(surface: Surface, used: NDArray[np.intp]) -> str:
    profile = surface.contact.profile
    first, last = used[0], used[-1]
    ratio = float(np.sqrt(profile.area[first] / profile.area[last]))
    k = surface.exponent
    exponent = "" if k is None else f"; apex exponent {k:.1f}"
    if surface.form in ("pillar", "plane", "edge") and surface.section != "segment":
        return f"sections hardly shrink toward the top: the highest keeps {ratio:.2f} of the lowest one's breadth"
    if surface.form == "frustum":
        top, base = surface.size[0], float(np.sqrt(profile.area[last]))
        base *= surface.size[0] / max(np.sqrt(_top_area(surface)), 1e-300)
        return f"sections shrink evenly to a flat top of about {top / max(base, 1e-300):.2f} of the base"
    if surface.form == "ridge" or surface.section == "segment":
        keep = _extent_ratio(surface, first, last)
        return f"sections shrink to a segment: the long side keeps {keep[0]:.2f}, the short one {keep[1]:.2f}{exponent}"
    if surface.form == "pyramidal":
        return f"sections shrink linearly to a point: the highest usable has {ratio:.2f} of the breadth{exponent}"
    if surface.form == "spherical":
        return f"sections shrink to a rounded point: the highest usable has {ratio:.2f} of the breadth{exponent}"
    return f"sections grow like no known form: the highest usable has {ratio:.2f} of the breadth{exponent}"


def _top_area(surface: Surface) -> float:
    long, short = surface.size
    return long * short * (np.pi / 4 if surface.section == "circle" else 1.0)


def _extent_ratio(surface: Surface, first: np.intp, last: np.intp) -> tuple[float, float]:
    covariance = surface.contact.profile.covariance
    high, low = (np.sqrt(np.maximum(np.linalg.eigvalsh(covariance[i]), 1e-300)) for i in (first, last))
    return float(high[1] / low[1]), float(high[0] / low[0])


def _decided(surface: Surface) -> list[str]:
    p = surface.kind_probability
    kind = int(np.argmax(np.where([k.name == surface.name for k in KINDS], p, -1.0)))
    others = np.where([k.name != surface.name for k in KINDS], p, -1.0)
    rival = int(np.argmax(others))
    weights = evidence(surface.inputs, surface.parameters, kind, rival)
    told = [f"{group} {nats:+.1f}" for group, nats in weights.items() if nats >= 0.5][:3]
    against = [f"{group} {nats:+.1f}" for group, nats in weights.items() if nats <= -0.5][-1:]
    if not told:
        return []
    rival_name = KINDS[rival].key.replace("-", " ")
    line = f"told from {rival_name} ({p[rival]:.2f}) by {', '.join(told)} nats"
    return [line + (f", against it {against[0]}" if against else "")]


def _cautions(surface: Surface) -> list[str]:
    said = []
    taxels = surface.area / surface.contact.taxel_area
    if taxels < _FEW_TAXELS:
        said.append(f"only about {taxels:.0f} taxels touch: the outline is hardly resolved")
    profile = surface.contact.profile
    if surface.form != "unknown" and np.any(profile.holes[profile.threshold > np.median(profile.threshold)] > 0):
        said.append("the pressure is highest along a ring, as under a flat face on a thick elastic skin")
    return said
