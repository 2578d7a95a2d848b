"""The nested outlines X_1 ... X_n over the taxels, each in the colour of its threshold."""

from __future__ import annotations

from markupsafe import Markup

from varishold.report.outline_path import UNITS_PER_TAXEL, path_data
from varishold.report.screen import fit, scale_bar, screen
from varishold.report.section_stack import SectionStack
from varishold.report.taxel_image import image_element

__all__ = ["outline_plot"]


def outline_plot(stack: SectionStack, *, unit_m: float | None, label: str) -> Markup:
    """Draw a contact's outlines, the lowest first.

    Parameters
    ----------
    stack : SectionStack
        The contact.
    unit_m : float or None
        The smaller taxel spacing in metres, where known.
    label : str
        Description for those who cannot see it.
    """
    place = fit(stack.window, below=20)
    body = [f'<g transform="{place.transform(UNITS_PER_TAXEL)}">', image_element(stack, stack.taxels, dim=True)]
    for i in range(len(stack) - 1, -1, -1):
        d = path_data(stack.outlines[i])
        body.append(f'<path class="level" data-i="{i}" stroke="{stack.colours[i]}" d="{d}"/>')
    body += ["</g>", scale_bar(place, unit_m)]
    return screen("".join(body), label=label, kind="outlines")
