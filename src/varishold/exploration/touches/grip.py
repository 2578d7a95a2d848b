"""What all grips have in common: their evidence is how sections fit, the switches, and the surfaces under all pads."""

from __future__ import annotations

from abc import abstractmethod

from varishold.exploration.capsules import grip_contacts
from varishold.exploration.touch import Felt, PadSurfaces, PoseEstimate, Touch, surfaces_of
from varishold.hand import Bench, HandSetting, Step
from varishold.hand.actions import object_middle
from varishold.hand.coordinates import gripped
from varishold.perceive import (
    Evidence,
    fit_section,
    form_values,
    grip_reasons,
    grip_values,
    pad_values,
    switch_values,
)
from varishold.touch import SURFACES

__all__ = ["Grip"]


class Grip(Touch):
    """A touch that closes the digits about the object."""

    @abstractmethod
    def close(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> tuple[Step, ...]:
        """Grip the object; return the steps, none where it was not found."""

    def make(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> Felt | None:
        steps = self.close(bench, pose, setting)
        if not steps or not steps[-1].felt:
            return None
        pose.middle_m = object_middle(bench)
        grip = gripped(steps[-1].sensed, bench.design, bench.layout)
        if grip is not None:
            pose.breadth_m, _ = grip
        return Felt(self, steps[-1])

    def evidence(self, felt: Felt, setting: HandSetting) -> tuple[Evidence, PadSurfaces]:
        sensed, pads = felt.step.sensed, setting.design.pads
        contacts = grip_contacts(sensed, setting.design, setting.layout)
        surfaces = surfaces_of(felt.step, setting, pads)
        circle = fit_section(contacts, "circle")
        values = grip_values(contacts)
        values |= switch_values(dict(zip(setting.layout.names, sensed.switches.tolist(), strict=True)))
        values |= form_values(contacts, surfaces)
        for name, surface in surfaces.items():
            values |= pad_values(name, surface, size_m=None if circle is None else circle.size_m)
        remarks = felt.missing(surfaces, pads)
        if circle is None:
            remarks += (f"{self.name}: fewer than three parts touch, so that no section can be fitted",)
        return Evidence(self.name, values, remarks, grip_reasons(contacts)), surfaces

    def felt_in_words(self, felt: Felt, surfaces: PadSurfaces) -> str:
        closed = felt.step.sensed.switches
        names = [surface.name for surface in surfaces.values() if surface is not None]
        told = ", ".join(f"{names.count(name)} {name}" for name in SURFACES if name in names)
        return f"{int(closed.sum())} of {len(closed)} switches closed, {len(names)} of {len(surfaces)} pads pressed" + (
            f" ({told})" if told else ""
        )
