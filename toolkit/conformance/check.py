"""What a user calls: is my joint, my load, my scene right in all its derivatives?"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.conformance.formula import check_load_formula
from toolkit.conformance.laws import check_laws
from toolkit.conformance.residual import check_design_derivatives, check_state_derivatives
from toolkit.conformance.response import check_partials
from toolkit.joints.joint import Joint
from toolkit.joints.row_checks import check_rows
from toolkit.loads.load import Load
from toolkit.responses.response import Response
from toolkit.scene.scene import Scene


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
        The joint names a body or a point that the scene does not have; or a row of it cannot be meant.
    """
    alone = _alone(scene, joints={"joint": joint})
    check_rows(joint, alone)
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
    """The scene's bodies and points with one component, which is refused if it names others."""
    return Scene(**{**dict(scene), "joints": {}, "loads": {}, "responses": {}, "design": {}, **component})
