"""The error that names where on its way an equilibrium lost its stability although the load went on: a bifurcation."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.errors import BifurcationError
from toolkit.system.system import System


def bifurcation(system: System, factor: float, motion: np.ndarray) -> BifurcationError:
    """Of critical load and motion (n,).

    At a limit point the stiffness vanishes against a motion on which the load does work, so that the load turns back. Where it vanishes
    while the load goes on, the load does no work on the motion: other branches of equilibria begin there.
    """
    coordinate = system.most_moved(motion)
    return BifurcationError(
        f"the equilibrium is unstable beyond a bifurcation (buckling) at {100 * factor:.6g} % of the load: the load does no work on a "
        f"motion of {coordinate}, which loses its stiffness there, and the smallest disturbance sets it off. Use less "
        "load, add stiffness there, or follow the motion with a transient run from a slightly disturbed start.",
        factor,
        coordinate,
    )
