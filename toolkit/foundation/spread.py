"""A few of many instants, for looks at a whole motion."""

from __future__ import annotations

import numpy as np


def spread(last: int, most: int) -> list[int]:
    """Numbers of instants spread evenly over a motion.

    Parameters
    ----------
    last
        Number of the last instant; the first is 0.
    most
        How many are wanted at most.

    Returns
    -------
    chosen
        Rising numbers from 0 to `last`, both among them.
    """
    return sorted({int(k) for k in np.linspace(0, last, min(most, last + 1)).round()})
