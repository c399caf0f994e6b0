"""A curve of one value."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.description.description import Number
from toolkit.description.quantity import OF_OWNER


class Constant(Curve):
    """f(t) = value.

    Attributes
    ----------
    value
        Value at all times.
    """

    kind = "constant"

    value: Annotated[Number, OF_OWNER] = 1.0

    def rates(self, _time: np.ndarray) -> tuple[Any, Any, Any]:
        """Value of the curve, with derivatives f' and f'' that are zero."""
        return self.value, 0.0, 0.0

    @property
    def is_constant(self) -> bool:
        """Whether the curve has one value at all times: always."""
        return True
