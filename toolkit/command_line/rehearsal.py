"""A run of the smallest scene there is, so that all that an analysis calls is compiled before it begins.

What is compiled depends on the dimension of space and on the analysis, but on no number of the scene; the formulas of its own kinds of
joints and loads come apart.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.analyses.sensitivity.adjoint import adjoint_gradients, has_adjoint
from toolkit.analyses.sensitivity.errors.excited_vibrations import lost_parts
from toolkit.analyses.sensitivity.preparation import Kind, evaluate_responses, prepare, solve
from toolkit.components.bodies.rigid import Rod, SpatialRod
from toolkit.components.joints.kernels.laws import SIGNATURE as LAW_SIGNATURE
from toolkit.components.joints.kernels.laws import teeth_law, turn_law
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.loads.gravity import Gravity, SpatialGravity
from toolkit.components.loads.kernels.load_kernel import SIGNATURE as LOAD_SIGNATURE
from toolkit.components.loads.load import Load
from toolkit.components.loads.springs import SpatialRotationalSpringDamper
from toolkit.description.description import Registered
from toolkit.description.design import Point
from toolkit.description.run_options import Formulation, RunOptions
from toolkit.foundation.kernel import first_class
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.scene.space import PLANE, SPACE, Space
from toolkit.system.evaluation import formulas_of
from toolkit.validity.energy_balance import energy_balance
from toolkit.validity.judge import judge


def rehearse(scene: Scene, kind: Kind, backwards: bool = False) -> None:
    """Call everything compiled that an analysis of the scene calls, with `backwards` its adjoint too."""
    formulas_of(loaded(scene))
    small = pendulum_like(scene)
    system = prepare(small, ["points.P.x"] if backwards else [])
    solution = solve(system, kind)
    evaluate_responses(solution)
    judge(solution)
    if len(solution.times) > 1:
        energy_balance(solution)  # a verdict asks for these where there are more steps than one
        lost_parts(solution, None, 0.0, np.ones(1), np.zeros(1))
    if backwards and has_adjoint(small, kind):
        adjoint_gradients(system, solution)


def rehearse_others(scene: Scene) -> None:
    """Call everything compiled that any analysis of such a scene calls: all formulations of joints share their code, but for the adjoint,
    which one of them lacks."""
    options = scene.solver.model_copy(update={"formulation": "index-1"})
    rehearse(scene.model_copy(update={"solver": options}), "transient", backwards=True)


def rehearse_everything(space: Space) -> None:
    """Call everything compiled that scenes of built-in kinds call in the plane or in space, and compile the formulas of these kinds."""
    scene = _small(space, "index-1", forced=True, coiled=True)
    rehearse(scene, "static")
    rehearse_others(scene)
    for law in (turn_law, teeth_law):
        first_class(law, LAW_SIGNATURE)
    for kind in space.kinds["loads"].values():
        if issubclass(kind, Load):
            first_class(kind.law(), LOAD_SIGNATURE)


def pendulum_like(scene: Scene) -> Scene:
    """Hanging rod of the scene's dimension and formulation for one step, with what else of the scene has code of its own."""
    judged = [*scene.responses.values(), *(getattr(each, "of", None) for each in scene.responses.values())]
    forced = any(isinstance(each, JointForce) for each in judged)
    coiled = any(isinstance(load, Load) and load.turn for load in scene.loads.values())
    return _small(scene.space, scene.solver.formulation, forced, coiled)


def _small(space: Space, formulation: Formulation, forced: bool, coiled: bool) -> Scene:
    """Smallest scene, a hanging rod; on request with its joint's force as a response, and with a spring whose turns count."""
    options = RunOptions(end_time=1e-3, step=1e-3, formulation=formulation, load_steps=1)
    responses: dict[str, Registered] = {"way": Displacement(body="rod", point="P", component="x")}
    if forced:
        responses["force"] = JointForce(joint="hinge", component="x")
    return _PENDULUMS[space](responses, options, coiled)


ENDS: dict[str, Any] = {"between": ("O", "P"), "area": 1e-4, "density": 7800.0}
"""Fields of the rod of the smallest scene."""


def _planar(responses: dict[str, Registered], options: RunOptions, _coiled: bool) -> Scene:
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=0.0, y=-1.0)},
        bodies={"rod": Rod(**ENDS)},
        joints={"hinge": Revolute(bodies=("rod", "ground"), point="O")},
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
        responses=responses,
        solver=options,
    )


def _spatial(responses: dict[str, Registered], options: RunOptions, coiled: bool) -> Scene:
    """Smallest spatial scene; on request with a rotational spring, whose turns compiled code counts."""
    spring = SpatialRotationalSpringDamper(bodies=("rod", "ground"), point="O", axis=(0.0, 1.0, 0.0), stiffness=1.0)
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={"O": Point(x=0.0, y=0.0, z=0.0), "P": Point(x=0.0, y=0.0, z=-1.0)},
        bodies={"rod": SpatialRod(**ENDS)},
        joints={"hinge": SpatialRevolute(bodies=("rod", "ground"), point="O", axis=(0.0, 1.0, 0.0))},
        loads={"weight": SpatialGravity(acceleration=(0.0, 0.0, -9.81)), **({"coil": spring} if coiled else {})},
        responses=responses,
        solver=options,
    )


_PENDULUMS = {PLANE: _planar, SPACE: _spatial}
