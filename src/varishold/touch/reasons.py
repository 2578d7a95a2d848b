"""Why touch says what it says: what was measured, and which measures decided."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.kernel import address, bind, work_space
from varishold.levelset.second_moments import principal_moments
from varishold.touch.caution import LIMITS, lines_across
from varishold.touch.decision import Parameters
from varishold.touch.names import KINDS, NAMES, SECTIONS
from varishold.touch.scale import bridged
from varishold.touch.signature import SIGNATURE_GROUPS

if TYPE_CHECKING:
    from varishold.touch.surface import Surface

__all__ = ["evidence", "reasons_for"]

# Sections of so many taxels tell how they grow.
_GROWN_TAXELS = 4
# A contact of fewer taxels than this has hardly an outline.
_FEW_TAXELS = 16.0
# Narrower than so many taxels, what is none of the plain forms cannot be told from a form that is seen too coarsely.
_FEW_ACROSS = 5.0
# A name of so narrow a contact that is less likely is one of several.
_LIKELY = 0.5
# What has no name is told beside a name that is sure where it is so probable.
_TOLD = 0.05
_GROUPS: tuple[str, ...] = tuple(dict.fromkeys(SIGNATURE_GROUPS))
_GROUP_OF = np.array([_GROUPS.index(group) for group in SIGNATURE_GROUPS], dtype=np.uint8)
_NAMED = {name: [k for k, kind in enumerate(KINDS) if kind.name == name] for name in NAMES}
_RIVALS = {name: [k for k, kind in enumerate(KINDS) if kind.name != name] for name in NAMES}
_OF_SECTION = {section: [k for k, kind in enumerate(KINDS) if kind.section == section] for section in SECTIONS}
_evidence = bind("vh_evidence", "ppppiiippp")
_hides_form = bind("vh_hides_form", "p", "i")
_may_be_strange = bind("vh_may_be_strange", "pd", "i")


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
    kernel = parameters.kernel
    given = np.array(inputs, np.float64)
    # With a skin file the same measures come again, of the reconstructed surface and of its pressure.
    groups = _GROUP_OF if len(inputs) == len(_GROUP_OF) else np.tile(_GROUP_OF, len(inputs) // len(_GROUP_OF))
    nats, logits = np.empty(len(_GROUPS)), np.empty(len(KINDS))
    usual = np.array(parameters.kind_means[rival])
    _evidence(
        *(kernel.at, address(given), address(usual), address(groups), len(_GROUPS), kind, rival),
        *(address(logits), address(nats), work_space(kernel.evidence_work)),
    )
    return dict(sorted(zip(_GROUPS, nats.tolist(), strict=True), key=lambda item: -item[1]))


def reasons_for(surface: Surface) -> tuple[str, ...]:
    """Return the reasons for a surface's name, the most telling first."""
    return (*_measured(surface), *_decided(surface), *_cautions(surface))


def _measured(surface: Surface) -> list[str]:
    said = []
    contact = surface.contact
    grown = _GROWN_TAXELS * contact.taxel_area
    if sum(map(grown.__le__, surface.areas)) >= 2:
        said.append(_growth(surface))
    if surface.section == "field":
        share = contact.n_taxels / max(int(contact.field.sum()), 1)
        said.append(f"the contact covers {share:.0%} of the field")
    elif surface.section != "unknown":
        p = surface.kind_probability.tolist()
        said.append(f"outline {surface.section} ({sum(p[k] for k in _OF_SECTION[surface.section]):.2f})")
    return said


def _growth(surface: Surface) -> str:
    """Tell how the sections grow, from breadths at fixed shares of the way from the top to the floor."""
    if surface.form in ("pillar", "plane", "edge") and surface.section != "segment":
        keep = _breadth(surface, 0.25) / _breadth(surface, 0.75)
        return f"sections hardly shrink: from one to three quarters of the height they keep {keep:.2f} of their breadth"
    if surface.form == "frustum":
        share = surface.size[0] / max(surface.breadths(surface.lowest)[0], 1e-300)
        return f"sections shrink evenly to a flat top of about {share:.2f} of the base"
    if surface.form == "ridge" or surface.section == "segment":
        long, short = (_breadths(surface, q) for q in (0.9, 0.3))
        return (
            f"sections shrink to a segment: near the top they keep {short[0] / long[0]:.2f} of their length, "
            f"{short[1] / long[1]:.2f} of their breadth{_exponent(surface)}"
        )
    half, exponent = _breadth(surface, 0.5) / _breadth(surface, 1.0), _exponent(surface)
    if surface.form == "pyramidal":
        return f"sections shrink to a point: half way up they have {half:.2f} of the lowest breadth{exponent}"
    if surface.form == "spherical":
        return f"sections shrink to a rounded point: half way up they have {half:.2f} of the lowest breadth{exponent}"
    return f"sections grow like no known form: half way up they have {half:.2f} of the lowest breadth{exponent}"


def _exponent(surface: Surface) -> str:
    k = surface.exponent
    return "" if k is None else f"; apex exponent {k:.1f}"


def _breadth(surface: Surface, q: float) -> float:
    return math.sqrt(surface.areas[surface.nearest(q)])


def _breadths(surface: Surface, q: float) -> tuple[float, float]:
    c = surface.profile.covariance[surface.nearest(q)]
    long, short = np.sqrt(np.maximum(principal_moments(c[0, 0], c[0, 1], c[1, 1]), 1e-300))
    return float(long), float(short)


def _decided(surface: Surface) -> list[str]:
    p = surface.kind_probability.tolist()
    kind = max(_NAMED[surface.name], key=p.__getitem__)
    rival = max(_RIVALS[surface.name], key=p.__getitem__)
    weights = evidence(surface.inputs, surface.parameters, kind, rival)
    # They fall: the first three speak most for it, the last most against. Only what is told is written out.
    ordered = list(weights.items())
    told = [f"{group} {nats:+.1f}" for group, nats in ordered[:3] if nats >= 0.5]
    if not told:
        return []
    last, least = ordered[-1]
    # What has no name of its own is told by what it is.
    named = KINDS[rival].name != "unknown"
    rival_name = KINDS[rival].name if named else KINDS[rival].key.replace("-", " ")
    line = f"told from {rival_name} ({p[rival]:.2f}) by {', '.join(told)} nats"
    return [f"{line}, against it {last} {least:+.1f}" if least <= -0.5 else line]


def _cautions(surface: Surface) -> list[str]:
    said = []
    if surface.contact.at_border and all(surface.contact.borders) and _hides_form(surface.contact.packed):
        said.append(
            "all of the field is pressed, and too few taxels or the sensor's end show nothing of a form: "
            "a plane, or whatever else is larger"
        )
    contact = surface.contact
    seen = bridged(contact) if contact.frame.has_gaps else contact
    held = [limit for limit in LIMITS if limit.holds(surface, seen)]
    said += [limit.says.format(across=counted(lines_across(seen), "taxel")) for limit in held]
    taxels = surface.area / surface.contact.taxel_area
    across = surface.breadths(surface.lowest)[1] / math.sqrt(surface.contact.taxel_area)
    if across < _FEW_ACROSS and (surface.name == "unknown" or surface.probability < _LIKELY):
        one = f"{surface.name} is but the likeliest of several"
        said.append(
            f"{across:.1f} taxels across, too small for a form: "
            f"{'unknown does not say that it is a strange one' if surface.name == 'unknown' else one}"
        )
    elif taxels < _FEW_TAXELS:
        said.append(f"only about {taxels:.0f} taxels touch: the outline is hardly resolved")
    if surface.name != "unknown" and _may_be_strange(contact.packed, surface.probability):
        strange = sum(surface.kind_probability[_NAMED["unknown"]].tolist())
        if strange >= _TOLD:
            said.append(f"{counted(contact.n_taxels, 'taxel')} cannot exclude a form that has no name ({strange:.2f})")
    profile = surface.profile
    if surface.form != "unknown" and any(profile.holes.tolist()):
        upper = profile.threshold > np.median(profile.threshold)
        if np.any(profile.holes[upper] > 0):
            said.append("the pressure is highest along a ring, as under a flat face on a thick elastic skin")
    return said
