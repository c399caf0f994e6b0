"""How far the load can grow before an equilibrium snaps through."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from toolkit.description.description import Positive
from toolkit.description.quantity import Quantity
from toolkit.foundation.errors import InputError
from toolkit.responses.response import Partials, Response
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene


class LoadMargin(Response):
    """Load factor of the first limit point, in parts of the full load: 1.3 says that an equilibrium snaps through when all loads have grown
    by 30 %, in proportion. Statics alone have it; a load that is beyond its limit point is followed there by `--past-limit`.

    Attributes
    ----------
    up_to
        Load factor up to which a limit point is looked for.
    """

    kind = "load-margin"
    quantity = "none"

    up_to: Annotated[Positive, Quantity("none")] = 10.0

    @property
    def needs_rest(self) -> bool:
        """Whether the response exists for an equilibrium only; always true of a load margin."""
        return True

    def partials(self, solution: Solution) -> Partials:
        """Load factor and its partial derivatives; the path goes beyond the full load unless it passed a limit point before.

        Raises
        ------
        InputError
            It is the steady state of a spin.
        ConvergenceError
            There is none up to `up_to`.
        BifurcationError
            The path loses its stability at a bifurcation before.
        """
        from toolkit.solvers.static.path.load_margin import factor_of_limit_point, next_limit_point  # read where one is asked for

        if solution.spins:
            raise InputError(
                "a load margin is that of an equilibrium at rest: a spin has no path of loads to follow. Leave out the response, or "
                'solver.equilibrium = "spinning".'
            )
        system, options = solution.system, solution.options or solution.system.scene.solver
        known = solution.path
        if known is not None and known.limit_points:
            at = known.limit_points[0].place
            z = np.concatenate([known.q[at], known.multipliers[at], known.load_factors[at : at + 1]])
        else:
            real = system if system.compiled else compile_scene(real_scene(system.scene))
            begin = np.concatenate([solution.q[-1], solution.multipliers[-1], [1.0]])
            z = next_limit_point(real, options, np.real(begin), self.up_to)
        value, design = factor_of_limit_point(system, options, np.real(z))
        return Partials(value, design=design)


def real_scene(scene: Scene) -> Scene:
    """Scene with the real parts of its numbers."""
    for path, value in list(scene.numbers()):
        if isinstance(value, complex):
            scene = scene.with_number(path, value.real)
    return scene
