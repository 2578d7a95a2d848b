"""A model's tables in the paper's form, for reading."""

from __future__ import annotations

from varishold.errors import InputError
from varishold.grasp.model import GraspModel

__all__ = ["describe_tables"]

#: Wider tables than this nobody reads; the numbers are in the model file.
_PRINTED_HYPERPLANES = 40
_MINIMIZED_HYPERPLANES = 16


def describe_tables(model: GraspModel) -> str:
    """Switches, hyperplanes, sign table, reduced tables and circuit of a model, as text.

    A mode that votes over many hyperplanes has no minimal table; what is too wide to read is left out,
    which is said.
    """
    clf = model.classifier
    planes = clf.hyperplanes_
    names = model.columns if model.encoder is None else tuple(model.encoder.get_feature_names_out(model.columns))
    blocks = ["Switches\n" + "\n".join(f"x{k + 1}  {name}" for k, name in enumerate(names))]
    if len(planes) > _PRINTED_HYPERPLANES:
        blocks.append(
            f"{len(planes)} hyperplanes, more than {_PRINTED_HYPERPLANES}: too many to print; "
            "the model file has them, and mode 'paper' learns as few as can be"
        )
        return "\n\n".join(blocks)
    blocks.append(f"Hyperplanes\n{planes}")
    if clf.selection_ is not None:
        blocks.append(str(clf.selection_))
    blocks.append(f"Sign table\n{clf.sign_table_}")
    try:
        blocks.append(f"Reduced sign table\n{clf.reduced_table_}")
        if len(planes) <= _MINIMIZED_HYPERPLANES:
            minimal = clf.minimal_table_
            circuit = "\n".join(f"{label} = {minimal.formula(label)}" for label in clf.classes_)
            blocks.append(f"Reduced sign table with don't-cares (*)\n{minimal}\n\n{circuit}")
    except InputError as error:
        blocks.append(f"The sign table cannot be reduced: {error}")
    blocks.append(f"Circuit (mode {clf.mode_})\n{model.netlist.diagram()}")
    return "\n\n".join(blocks)
