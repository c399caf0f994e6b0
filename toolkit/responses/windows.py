"""Responses of a run whose states are never all there: each window's own value and partials, put together.

    f = F(f_1, ..., f_m),   df/dq_n = F_j df_j/dq_n   for a state n in window j

with f_j the response of window j alone. A maximum is the maximum of those of the windows, a Kreisselmeier-Steinhauser function that of
theirs, an integral their sum (see `OverTime.combined`); what looks at one time needs one window. A response of another kind needs a
function for it here, registered with `combine.register`.
"""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import RESULT_TIE_BAND, first_largest
from toolkit.foundation.value_types import Scalar
from toolkit.responses.over_time import OverTime
from toolkit.responses.response import Instant, Response
from toolkit.responses.stress import KSStress, MaxStress, StressResponse, kreisselmeier_steinhauser
from toolkit.responses.vibration import OfVibration


@singledispatch
def steps_seen(response: Response, times: np.ndarray) -> tuple[int, int]:
    """First and last step that a response looks at, of those of the run; all unless a kind says otherwise."""
    return 0, len(times) - 1


@steps_seen.register
def _(response: Instant, times: np.ndarray) -> tuple[int, int]:
    step = response.nearest(times)
    return step, step


@steps_seen.register
def _(response: StressResponse, times: np.ndarray) -> tuple[int, int]:
    return (0 if response.when == "all" else len(times) - 1), len(times) - 1


@steps_seen.register
def _(response: OfVibration, times: np.ndarray) -> tuple[int, int]:
    return len(times) - 1, len(times) - 1


@singledispatch
def combine(response: Response, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
    """Response of the whole run from those of its windows (m,), and its derivatives by them (m,).

    Raises
    ------
    InputError
        Nobody has said how responses of this kind are put together.
    """
    if len(values) != 1:
        raise InputError(
            f"a response of kind {response.kind!r} cannot be put together from windows of a run whose states exceed solver.memory. "
            "Raise solver.memory, or register a function for it with toolkit.responses.windows.combine."
        )
    return values[0], np.ones(1)


@combine.register
def _(response: OverTime, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
    return response.combined(values)


@combine.register
def _(response: KSStress, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
    return kreisselmeier_steinhauser(values, response.sharpness)


@combine.register
def _(response: MaxStress, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
    place = first_largest(np.real(values), RESULT_TIE_BAND)
    return values[place], (np.arange(len(values)) == place).astype(float)
