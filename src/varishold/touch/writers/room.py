"""How much room a recognizer takes, asked of the kernel in single precision."""

from __future__ import annotations

import ctypes

from varishold.kernel.library import library
from varishold.touch.network import KernelLayer, kernel_struct
from varishold.touch.writers.pad import Export

__all__ = ["room_bytes"]


_Parameters = kernel_struct(ctypes.c_float)


class _Pad(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_int) for name in ("rows", "cols", "levels", "contacts")),
        *((name, ctypes.c_float) for name in ("row_pitch", "col_pitch")),
        *((name, ctypes.c_void_p) for name in ("sensor", "parameters")),
    ]


def room_bytes(wanted: Export) -> int:
    """Return the bytes of work space that the exported ``vh_feel`` takes; where pointers are shorter it may be less.

    Parameters
    ----------
    wanted : Export
    """
    decision = wanted.decision
    layers = (KernelLayer * len(decision.weights))(*(KernelLayer(*weight.shape) for weight in decision.weights))
    parameters = _Parameters(inputs=len(decision.shift), kinds=len(decision.name_of), n_layers=len(layers))
    parameters.layers = ctypes.addressof(layers)
    parameters.whiten.outputs = decision.whiten.shape[1]
    pad = _Pad(*wanted.rows_and_cols, wanted.levels, wanted.contacts, 1.0, 1.0, None, ctypes.addressof(parameters))
    function = library("single").vh_feel_work
    function.restype = ctypes.c_size_t
    return int(function(ctypes.byref(pad)))
