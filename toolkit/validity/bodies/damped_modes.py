"""How far dampers change frequencies, while modes are those of the undamped scene."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution, check

SEEN, LARGE = 0.01, 0.3
"""Parts of the critical damping above which it is told, and of the lowest frequency above which it is a doubt: sqrt(1 - 0.3^2) is 5 %
below one."""


@check("damped")
def cautions_of_damping(damping: np.ndarray, mass: np.ndarray, squares: np.ndarray, shapes: np.ndarray) -> Iterator[Caution]:
    """Frequencies are undamped, and the scene has dampers.

    Limit: 1 % of the critical damping; a doubt from 30 % of the lowest frequency's on.
    Fix: the responses `damped-frequency` and `damping-ratio`.

        zeta_k = y_k^T C y_k / (2 omega_k y_k^T M y_k),    damped frequency omega_k sqrt(1 - zeta_k^2)

    Parameters
    ----------
    damping, mass : array (n_q, n_q)
        C and M.
    squares : array (n_modes,)
        omega^2.
    shapes : array (n_q, n_modes)
        y.
    """
    vibrating = squares > 0
    damped, inert = (np.einsum("im,ij,jm->m", shapes, each, shapes)[vibrating] for each in (damping, mass))
    ratios = damped / (2 * np.sqrt(squares[vibrating]) * inert)
    if not ratios.size or not ratios.max() > SEEN:
        return
    most = int(np.argmax(ratios > LARGE if ratios.max() > LARGE else ratios > SEEN))
    yield cautions_of_damping.caution(
        f"these frequencies are undamped. Damping is up to {ratios.max():.2g} of the critical one; that at "
        + ("lowers it by " + f"{1 - np.sqrt(1 - ratios[most] ** 2):.1%}." if ratios[most] < 1 else "does not vibrate at all."),
        doubt=bool(ratios[0] > LARGE),
    )
