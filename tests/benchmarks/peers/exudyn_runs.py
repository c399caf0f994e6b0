"""Exudyn's settings: all that its documentation advises for speed, of which the fastest counts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import exudyn
import numpy as np

from tests.benchmarks.peers.contest import DidNotConverge, Maker

SETTINGS = {
    "full Newton": {"useModifiedNewton": False},
    "one Jacobian a step": {"useModifiedNewton": True, "modifiedNewtonJacUpdatePerStep": True},
    "modified Newton": {"useModifiedNewton": True},
}


def makers(
    scene: Callable[[], tuple[Any, Callable[[], np.ndarray]]], end_time: float, rho_inf: float, solvers: Iterable[str]
) -> dict[str, Maker]:
    """Every kind of Newton iteration with every linear solver.

    Parameters
    ----------
    scene
        Makes the system, and a function that reads what is compared from its last state.
    end_time, rho_inf
        Of the generalized-alpha method.
    solvers
        Names of Exudyn's linear solvers: "EigenDense", "EigenSparse".
    """

    def maker(newton: dict[str, bool], solver: str) -> Maker:
        def make(step: float) -> Callable[[], np.ndarray]:
            system, result = scene()
            settings = _settings(newton, solver, end_time, round(end_time / step), rho_inf)

            def motion() -> np.ndarray:
                try:
                    system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha)
                except exudyn.SolverError as error:
                    raise DidNotConverge(str(error)) from error
                return result()

            return motion

        return make

    return {
        f"Exudyn, {name}, {solver.removeprefix('Eigen').lower()}": maker(newton, solver)
        for name, newton in SETTINGS.items()
        for solver in solvers
    }


def _settings(newton: dict[str, bool], solver: str, end_time: float, steps: int, rho_inf: float) -> Any:
    """Constant steps, no files, the pattern of sparse matrices analysed once."""
    settings = exudyn.SimulationSettings()
    time = settings.timeIntegration
    time.endTime, time.numberOfSteps, time.adaptiveStep, time.verboseMode = end_time, steps, False, 0
    time.generalizedAlpha.spectralRadius = rho_inf
    for key, value in newton.items():
        setattr(time.newton, key, value)
    settings.solution.file.write = False
    settings.linearSolver.solverType = getattr(exudyn.LinearSolverType, solver)
    settings.linearSolver.reuseAnalyzedPattern = solver == "EigenSparse"
    return settings
