"""What a calibration by known objects says: what it found, what it could not know, and what else one should know."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from varishold.calibration.agreement import LEAST_SPREAD, hardly_pressed
from varishold.calibration.covers import SPRINGS
from varishold.calibration.explanation import BLUR, DEAD, Explanation, Hypothesis, Observations
from varishold.calibration.gains_of_objects import ObjectGains
from varishold.calibration.result import Finding
from varishold.calibration.thickness import POISSON, Thickness, has_floor, tells_thickness
from varishold.sensor import Linear, Sensor

__all__ = ["findings_of", "gain_notes_of", "notes_of", "unknown_of"]


def findings_of(
    explanation: Explanation, thickness: Thickness | None, gains: ObjectGains | None
) -> tuple[Finding, ...]:
    """Return what was measured; `thickness` and `gains` where they were found and are applied."""
    return (
        *_of_response(explanation),
        *([] if thickness is None else [_thickness_finding(thickness)]),
        *([] if gains is None else [_gain_finding(gains)]),
    )


def _of_response(explanation: Explanation) -> list[Finding]:
    family, constants, error = explanation.family, explanation.constants, explanation.error
    findings = [
        Finding(key, float(value), float(value * error[3]), family.says)
        for key, value in family.response(constants[3:]).entries().items()
    ]
    if explanation.dead:
        findings.append(
            Finding(
                "dead_band", float(constants[DEAD]), float(error[DEAD]), "share of full scale that is not felt", True
            )
        )
    if not explanation.well:
        return findings
    blur, spread = float(np.sqrt(constants[BLUR])), float(error[BLUR])
    findings.append(
        Finding(
            "blur_taxels",
            blur,
            float(spread / max(2 * blur, np.sqrt(spread), 1e-9)),
            "standard deviation, in taxels, of what spreads to neighbours: crosstalk and a thin cover together",
        )
    )
    return findings


def _thickness_finding(thickness: Thickness) -> Finding:
    return Finding(
        "thickness_m",
        thickness.metres,
        thickness.error,
        f"of what covers the taxels, in metres, were its Poisson's ratio {POISSON:g}",
    )


def _gain_finding(gains: ObjectGains) -> Finding:
    return Finding(
        "gain_spread",
        gains.agreed.spread,
        gains.spread_error,
        "how much the taxels' gains differ, as two halves of the presses agree; each is known to "
        f"{100 * float(np.median(gains.error[gains.known])):.2g} %",
        share=True,
    )


def unknown_of(
    known: Sensor, given: Observations, explanation: Explanation, *, curved: bool, has_gains: bool
) -> tuple[str, ...]:
    """Say what could not be known from these presses, and what would tell it.

    `curved`: whether something round pressed; `has_gains`: whether the sensor that is written has gains.
    """
    unknown = []
    if not curved:
        unknown.append("the response: a flat face presses everywhere alike; press a ball or a roller too")
    if not explanation.dead:
        unknown.append("a dead band: without one these presses are explained as well, were they less deep")
    if not explanation.well:
        unknown.append("a blur: unequal gains, another response and another form look like one; find these first")
    if not has_gains:
        unknown.append(
            "the gains: use an even pressure or unlabelled presses first, and give that sensor file (sensor)"
        )
    return (*unknown, _cover_unknown(known, given))


def _cover_unknown(known: Sensor, given: Observations) -> str:
    """Say what is not known of the cover."""
    if known.cover is not None:
        return "the cover's modulus: it is taken as the sensor file says it"
    if given.points.cover != SPRINGS:
        return f"the cover's modulus and Poisson's ratio, which is taken as {POISSON:g}"
    if tells_thickness(given):
        return "the cover's thickness and modulus: springs explain these presses as well as a layer does"
    return (
        "the cover's thickness and modulus: a thick one presses a ball as a bent response does; press a ball or a "
        "roller and a plate or a disc"
    )


def notes_of(known: Sensor, explanation: Explanation, tried: Mapping[str, float]) -> list[str]:
    """Say how well the presses are explained, and by what cover; `tried`: what each hypothesis leaves of them."""
    notes = []
    if len(tried) > 1:
        if not explanation.hypothesis.bends:
            notes.append("the response is linear, as far as these presses tell")
        others = ", ".join(f"{name} {cost:.2f}" for name, cost in tried.items())
        notes.append(f"presses left out of the fit are explained to so many sigmas: {others}")
    if not explanation.well:
        notes.append(
            f"the fit leaves {explanation.typical:.2g} times what noise and a hundredth of the peak would: these "
            "presses are not quite of such objects (is each of the form and size that was said? do the "
            "taxels' gains differ?), and what was found may be off by more than it says"
        )
    return notes if known.cover is not None else [*notes, *_cover_notes(explanation.hypothesis)]


def _cover_notes(hypothesis: Hypothesis) -> list[str]:
    if hypothesis.cover == SPRINGS:
        return []
    if not has_floor(hypothesis.cover):
        return ["what covers the taxels is so thick that its floor is not felt"]
    return ["no [skin] is written, as names are learned from what covers do; add it to fit forms through it"]


def gain_notes_of(known: Sensor, given: Observations, explanation: Explanation, gains: ObjectGains | None) -> list[str]:
    """Say what was found of the gains and is not applied, and what this response makes of those that were there."""
    if gains is not None and not gains.worth:
        return [gains.refusal] if gains.agreed.spread >= LEAST_SPREAD else []
    if gains is not None:
        return hardly_pressed(given.usable & ~gains.known)
    if known.gains is None or not explanation.hypothesis.bends or not isinstance(known.response, Linear):
        return []
    if given.gain_readings is not None:
        return ["the gains were found from an even pressure without this response, and are now those behind it"]
    return [
        "if the gains were found without this response they are off by its bend: find them once more with the file "
        "that is written here as the sensor, from the even pressure again"
    ]
