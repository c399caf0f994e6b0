"""The open formulas of a joint on their own: each derivative that they fill against a complex step of what they fill before."""

from __future__ import annotations

import numpy as np

from toolkit.conformance.comparison import compare
from toolkit.conformance.formula import moved_numbers, stepped
from toolkit.foundation.kernel import plain
from toolkit.joints.joint import Joint
from toolkit.joints.kernels.profile import profile_law
from toolkit.joints.rows import Row
from toolkit.scene.scene import Scene


def check_laws(joint: Joint, scene: Scene, rng: np.random.Generator) -> None:
    """g_h of g, g_hh of g_h, and g_hww of w^T g_hh w, at random values and rates of all forms that are no constants.

    A constant that no number of the scene moves, a switch, has no derivative that anyone could use.
    """
    moved, before = moved_numbers("joints", joint, scene), 0
    for row in joint.constraint(scene):
        used = []
        for f, form in enumerate(row.forms):
            last = before + len(form.numbers)
            if form.linear or form.pairs or moved[before:last].any():
                used.append(f)
            before = last
        if row.law not in (None, profile_law):  # numbers of a profile are no forms: the equations of the whole scene judge them
            _check_law(joint, row, np.array(used, int), rng)


def _check_law(joint: Joint, row: Row, used: np.ndarray, rng: np.random.Generator) -> None:
    n = len(row.forms)
    h, w = rng.normal(size=(2, n))
    for f, form in enumerate(row.forms):
        if not (form.linear or form.pairs):
            h[f], w[f] = form.constant, 0.0

    def fill(at: np.ndarray) -> list[np.ndarray]:
        filled = [np.zeros(shape, at.dtype) for shape in ((1,), (n,), (n, n), (n,))]
        plain(row.law)(at, w.astype(at.dtype), *filled)
        return filled

    _, g_h, g_hh, g_hww = fill(h)
    owner, names = f"row {row.name!r} of {joint.kind!r}: ", [f"h[{f}]" for f in used]
    compare(f"{owner}g_h", g_h[None, used], stepped(lambda at: fill(at)[0], h, used), [[row.name], names])
    second, exact = g_hh[np.ix_(used, used)], stepped(lambda at: fill(at)[1][used], h, used)
    compare(f"{owner}g_hh", second, exact, [names, names])
    exact = stepped(lambda at: (w @ fill(at)[2] @ w)[None], h, used)
    compare(f"{owner}g_hww", g_hww[None, used], exact, [[row.name], names])
