"""The report: results as figures and as a page that works offline.

`write_touch_report` writes the page of a recording's contacts, `write_perceive_report` that of a sequence of touches
at one object, `write_evaluation_report` that of how well things are told apart, `write_corpus_report` that of many
recordings. Drawing lives nowhere else: each
picture is a pure function of its own file, from a contact's `SectionStack` to SVG (`taxel_image`, `outline_plot`,
`axonometry`, `chord_plot`); `draw_contact_card` puts them together, `page` fills the one base template.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "ContactCard",
    "SectionStack",
    "draw_contact_card",
    "render_calibration_report",
    "render_corpus_report",
    "render_evaluation_report",
    "render_perceive_report",
    "render_touch_report",
    "stack_sections",
    "write_calibration_report",
    "write_corpus_report",
    "write_evaluation_report",
    "write_perceive_report",
    "write_touch_report",
]

if TYPE_CHECKING:
    from varishold.report.calibration_report import render_calibration_report, write_calibration_report
    from varishold.report.contact_card import ContactCard, draw_contact_card
    from varishold.report.corpus_report import render_corpus_report, write_corpus_report
    from varishold.report.evaluation_report import render_evaluation_report, write_evaluation_report
    from varishold.report.perceive_report import render_perceive_report, write_perceive_report
    from varishold.report.section_stack import SectionStack, stack_sections
    from varishold.report.touch_report import render_touch_report, write_touch_report
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
