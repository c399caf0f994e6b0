"""What can make the equations singular: constraints that repeat others, and frames that are fixed by mistake."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.body import Body
from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.errors import SingularSystemError, quoted
from toolkit.reduced_model.model import MEAN_AXES
from toolkit.scene.scene import Scene

REPEATED_ROW, NEARLY_REPEATED_ROW = 1e-9, 1e-5
"""Part of a row, of length one, that is independent of the rows before it, below which it repeats them, and below which it nearly does:
such a joint jams, because points or axes do not fit."""
QUATERNION_PRIORITY = 1e3
"""Factor by which the lengths of quaternions come first: they are never dropped."""
LONG_ROW_PART = 0.63
"""Part of the longest row that is left from which a row is long enough to be taken. Rows of mechanisms are often equally long:
the first of them in the order of the scene is taken, so that a joint repeats those before it, and the same one on every
processor. No ratio of lengths that people choose."""


class Rows(NamedTuple):
    """Numbers of the rows of a Jacobian that are kept, of those that repeat others, and of those that nearly do."""

    kept: np.ndarray
    repeating: np.ndarray
    almost: np.ndarray  # of those that are kept


def independent_rows(jacobian: np.ndarray, weights: np.ndarray, first: np.ndarray) -> Rows:
    """Rows of a Jacobian (n_lam, n_q) that repeat the others, and those that nearly do.

    Orthogonalisation by Gram and Schmidt with pivoting, rows scaled to length one for coordinates divided by their weights
    (n_q,); rows in `first` are taken before all others.
    """
    rows = np.real(jacobian) / weights
    rows = rows / np.sqrt(np.sum(rows * rows, axis=1, keepdims=True)).clip(np.finfo(float).tiny)
    rows[first] *= QUATERNION_PRIORITY
    numbers, kept, almost = np.arange(len(rows)), list[int](), list[int]()
    while len(rows):
        size = np.sqrt(np.sum(rows * rows, axis=1))
        if size.max() <= REPEATED_ROW:
            break
        place = int(np.argmax(size >= LONG_ROW_PART * size.max()))
        kept.append(int(numbers[place]))
        if size[place] <= NEARLY_REPEATED_ROW:
            almost.append(int(numbers[place]))
        unit, others = rows[place] / size[place], np.arange(len(rows)) != place
        numbers, rows = numbers[others], rows[others]
        rows = rows - np.outer(rows @ unit, unit)
    return Rows(np.sort(kept).astype(int), numbers, np.sort(almost).astype(int))


def null_vectors(jacobian: np.ndarray, kept: np.ndarray, repeating: np.ndarray) -> np.ndarray:
    """Null vectors N (n_lam, k) with J^T N = 0, one for every repeating row d.

    N_d = e_d - C_d^T with J_d = C_d J_K for the rows K that are kept.

    Complex-safe: without a conjugate.
    """
    found: np.ndarray = np.zeros((len(jacobian), len(repeating)), jacobian.dtype)
    own = jacobian[kept]
    found[repeating, np.arange(len(repeating))] = 1
    try:
        found[kept] = -np.linalg.solve(own @ own.T, own @ jacobian[repeating].T)
    except np.linalg.LinAlgError as error:
        raise SingularSystemError(
            "the joints cannot be told apart: their lengths differ so much that round-off decides which of them repeat others. "
            "Check the points and their units."
        ) from error
    return found


def grounded(scene: Scene) -> dict[str, Body]:
    """Bodies of the scene whose frame is fixed to the ground."""
    return {name: body for name, body in scene.bodies.items() if not body.has_frame}


def floats_with_its_clamp(scene: Scene, name: str) -> bool:
    """Whether a body is a flexible one that its own model clamps, in a frame that moves."""
    body = scene.bodies.get(name)
    return isinstance(body, ModelBody) and body.has_frame and scene.model(body.model).reference_condition != MEAN_AXES


def hint_of_grounded(scene: Scene, joints: Iterable[str]) -> str:
    """A sentence on the grounded bodies that take part in joints; empty if there are none."""
    fixed, joined = grounded(scene), {body for joint in joints for body in scene.joints[joint].bodies}
    named = [name for name in fixed if name in joined]
    if not named:
        return ""
    which = f"Body {named[0]!r} is" if len(named) == 1 else f"Bodies {quoted(named)} are"
    return f' {which} fixed to the ground by frame = "grounded", the likely cause if it is a part of the mechanism: write frame = "moving".'


def hint_of_floating(scene: Scene, bodies: Iterable[str]) -> str:
    """A sentence on the bodies that `frame = "grounded"` would hold by the clamp of their models; empty if there are none."""
    named = [name for name in dict.fromkeys(bodies) if floats_with_its_clamp(scene, name)]
    if not named:
        return ""
    which = f"Body {named[0]!r} moves" if len(named) == 1 else f"Bodies {quoted(named)} move"
    return f' {which} with the frame; frame = "grounded" fixes what the reduced model clamps to the ground.'
