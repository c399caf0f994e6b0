"""The compiled scene: numbering, plan, functions and start values; made once, never changed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.design import Design
from toolkit.equations import Inputs, Plan
from toolkit.joints.joint_kernel import SIGNATURE as JOINT_SIGNATURE
from toolkit.joints.revolute import revolute
from toolkit.kernel import plain, slots
from toolkit.loads.load_kernel import SIGNATURE as LOAD_SIGNATURE
from toolkit.loads.torque import torque
from toolkit.numbering import Numbering, coordinate_weights, number
from toolkit.plan import build_plan, families
from toolkit.quantities import STEP, Quantities, derivative, evaluate_quantities, loads_of
from toolkit.scene import Scene


@dataclass(frozen=True)
class System:
    """A scene made ready to be solved.

    Real systems run compiled; a system whose scene holds a complex number (see `sensitivity.numerical`) runs the same formulas as plain
    Python. `functions` are the formulas of the joints and loads that the scene uses.
    """

    scene: Scene
    design: Design
    numbering: Numbering
    plan: Plan
    values: Quantities
    derivatives: list[Quantities]
    functions: tuple
    dtype: type
    weights: np.ndarray  # (n_q,) see `coordinate_weights`

    @property
    def n_q(self) -> int:
        """Number of coordinates."""
        return self.plan.n_q

    @property
    def n(self) -> int:
        """Number of unknowns: coordinates and multipliers."""
        return self.plan.n

    @property
    def n_x(self) -> int:
        """Number of design variables."""
        return self.plan.n_x

    @property
    def compiled(self) -> bool:
        """Whether the formulas run compiled."""
        return self.dtype is float

    def kernel(self, function):
        """A kernel as it has to be called for this system: compiled, or as plain Python."""
        return function if self.compiled else plain(function)

    def start(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Undeformed coordinates, given velocities, and their design derivatives (n_q, n_x)."""
        d = self.derivatives
        dq = np.stack([np.zeros(self.n_q), *(each.q0 for each in d)], axis=1)[:, 1:]
        dv = np.stack([np.zeros(self.n_q), *(each.v0 for each in d)], axis=1)[:, 1:]
        return self.values.q0.astype(self.dtype), self.values.v0.astype(self.dtype), dq, dv

    def curves(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """f, f', f'' of all time curves (n_t, n_curves, 3) and of their active design derivatives (n_t, n_d, 3)."""
        curves = [curve.evaluate(times) for curve in self.values.curves]
        pairs = zip(self.plan.curve_index, self.plan.curve_variable, strict=True)
        changes = [np.imag(self.derivatives[x].curves[c].evaluate(times)) / STEP for c, x in pairs]
        return (
            np.ascontiguousarray(np.stack([np.zeros((len(times), 3)), *curves], axis=1)[:, 1:], self.dtype),
            np.ascontiguousarray(np.stack([np.zeros((len(times), 3)), *changes], axis=1)[:, 1:], float),
        )

    def inputs(self, time: float, levels: np.ndarray, scale: float = 1.0) -> Inputs:
        """What acts at one time."""
        curves, curves_x = self.curves(np.array([time]))
        return Inputs(curves[0], curves_x[0], scale, np.asarray(levels, float))


def compile_scene(scene: Scene, design: list[str] | None = None, markers: tuple[tuple[str, str], ...] = ()) -> System:
    """Compile a scene with the named design variables (none by default) and, on request, markers that no component needs.

    Raises
    ------
    InputError
        A name, a path, a body's grip or a parameter is wrong.
    """
    variables = scene.design_variables(design or [])
    numbering = number(scene, markers)
    values = evaluate_quantities(scene, numbering)
    derivatives = [derivative(scene, numbering, variable.path) for variable in variables]
    dtype = complex if any(isinstance(value, complex) for _, value in scene.numbers()) else float
    plan = build_plan(scene, numbering, values, derivatives, dtype)
    joint_formulas = families(list(scene.joints.values())) or [revolute]
    load_formulas = families(loads_of(scene)) or [torque]
    if dtype is float:
        functions = slots(joint_formulas, JOINT_SIGNATURE), slots(load_formulas, LOAD_SIGNATURE)
    else:
        functions = tuple(plain(f) for f in joint_formulas), tuple(plain(f) for f in load_formulas)
    return System(scene, variables, numbering, plan, values, derivatives, functions, dtype, coordinate_weights(scene))
