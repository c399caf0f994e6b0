"""The slowest vibration on the whole way of a static load: how near it comes to a limit point that is not there yet."""

from __future__ import annotations

from dataclasses import replace

from toolkit.foundation.errors import InputError
from toolkit.responses.load_margin import real_scene
from toolkit.responses.response import Partials, Response
from toolkit.responses.vibrations.softest_way import Way, frequency_at, path_from_rest
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene


class LeastFrequency(Response):
    """Least frequency of the slowest vibration about all equilibria between the unloaded state and the full load, in cycles per time. It
    goes to zero where a limit point is born on the way, at which a load margin jumps without a warning. Statics alone have it.
    """

    kind = "least-frequency"
    quantity = "rate"

    @property
    def needs_rest(self) -> bool:
        """Whether the response exists for an equilibrium only; always true of a least frequency."""
        return True

    def partials(self, solution: Solution) -> Partials:
        """Value and partial derivatives at the load factor of the least frequency, which is searched along the path.

        Raises
        ------
        InputError
            It is the steady state of a spin, or the path has snapped through.
        ConvergenceError
            The path from the unloaded state does not lead to the full load.
        """
        system, options = solution.system, solution.options or solution.system.scene.solver
        if solution.spins or (solution.path is not None and solution.path.limit_points):
            raise InputError(
                "a least frequency is that of a path of loads at rest that does not snap through. Leave out the response, "
                'solver.equilibrium = "spinning" or solver.continuation = "arc-length".'
            )
        real = system if system.compiled else compile_scene(real_scene(system.scene))
        way = Way(replace(solution, system=real), options, solution.path or path_from_rest(real, options))
        factor = way.softest()
        return frequency_at(solution, options, factor, way.state(factor))
