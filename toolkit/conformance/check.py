"""Checks for users: whether one's own joint, load or scene is right in all its derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.conformance.comparison import compare
from toolkit.conformance.formula import check_load_formula, moved_numbers, stepped
from toolkit.conformance.residual import check_design_derivatives, check_state_derivatives
from toolkit.conformance.response import check_partials
from toolkit.foundation.kernel import plain
from toolkit.joints.joint import Joint, check_rows
from toolkit.joints.kernels.profile import profile_law
from toolkit.joints.rows import Row
from toolkit.loads.load import Load
from toolkit.responses.response import Response
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene


def check_laws(joint: Joint, scene: Scene, rng: np.random.Generator) -> None:
    """g_h of g, g_hh of g_h, and g_hww of w^T g_hh w, at random values and rates of all forms that are no constants.

    A constant that no number of the scene moves, a switch, has no derivative that anyone could use.
    """
    moved, before = moved_numbers("joints", joint, scene), 0
    for row in joint.constraint(loaded(scene)):
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


def check_joint(joint: Joint, scene: Scene, seed: int = 0) -> None:
    """Check every derivative of a joint at random poses and rates: those of its open formulas, then what the equations make of them.

    Rows that are forms have no derivatives of their own.

    Parameters
    ----------
    joint : the joint; its bodies and points are those of the scene
    scene : any scene with those bodies and points; its own joints and loads are left out
    seed : another one gives other poses and rates

    Raises
    ------
    ConformanceError
        A derivative differs from a complex step by more than 1e-10 of the largest; names the derivative, the entry and both values.
    ValueError
        The joint names a body or a point that the scene does not have; or a row of it is invalid.
    """
    alone = _alone(scene, joints={"joint": joint})
    check_rows(joint, loaded(alone))
    check_laws(joint, alone, np.random.default_rng(seed))
    check_scene(alone, seed)


def check_load(load: Load, scene: Scene, seed: int = 0) -> None:
    """Check every derivative of a load; arguments and errors as `check_joint`."""
    alone = _alone(scene, loads={"load": load})
    check_load_formula(load, alone, np.random.default_rng(seed))
    check_scene(alone, seed)


def check_response(response: Response, scene: Scene, seed: int = 0) -> None:
    """Check a response's partial derivatives by the states at every time, and by every number that can be a design variable.

    Parameters
    ----------
    response : the response; its bodies and points are those of the scene
    scene : any scene with those bodies, points, joints and loads
    seed : another one gives other states

    Raises
    ------
    ConformanceError
        A derivative differs from a complex step by more than 1e-10 of the largest; names the derivative, the entry and both values.
    InputError
        The response asks for what the scene does not have.
    """
    alone = Scene(**{**dict(scene), "responses": {"response": response}, "design": {}})
    check_partials(response, alone, seed)


def check_scene(scene: Scene, seed: int = 0) -> None:
    """Check the derivatives of a whole scene's equations by its state, and by every number that can be a design variable.

    The compiled equations run against complex steps of the same equations as plain Python, so a formula with a branch that only
    one of both takes is found too. Errors as `check_joint`.
    """
    check_state_derivatives(scene, seed)
    check_design_derivatives(scene, seed)


def _alone(scene: Scene, **component: Any) -> Scene:
    """Scene with its bodies and points and one component alone, which is refused if it names others."""
    return Scene(**{**dict(scene), "joints": {}, "loads": {}, "responses": {}, "design": {}, **component})
