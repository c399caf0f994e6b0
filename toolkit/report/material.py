"""What a report is made of: one solution, its results, and the gradients of the methods that judge them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.certificate.certificate import Certificate, compare
from toolkit.analyses.sensitivity.direct import numerical
from toolkit.analyses.sensitivity.preparation import Kind
from toolkit.analyses.sensitivity.run import Run
from toolkit.files.results import Results
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import spread
from toolkit.render.animation import MOST_FRAMES
from toolkit.render.pictures import chosen_steps
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.look import Look, choose_look, drawn_points
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.equations import allocate_work
from toolkit.system.solution import Solution
from toolkit.validity.energy_balance import EnergyBalance, energy_balance, largest_drift


class Monitors(NamedTuple):
    """Energies in the scene's unit, and at every time the drift (n_t,), relative to the model size (or in rad)."""

    energy: EnergyBalance
    drift: np.ndarray


def monitor(solution: Solution) -> Monitors:
    """Energies and drift of a motion."""
    return Monitors(energy_balance(solution), drift(solution))


def drift(solution: Solution) -> np.ndarray:
    """Largest constraint violation of any joint at every time, (n_t,)."""
    system = solution.system
    curves, _ = system.curves(solution.times)
    work, rest, found = allocate_work(system.plan, system.dtype), np.zeros(system.n), np.zeros((len(solution.times), 4))
    for n, q in enumerate(solution.q):
        state = np.concatenate([q, rest[system.n_q :]])[None]
        system.run(largest_drift, system.plan, system.functions, curves[n : n + 1], system.weights, state, rest, found[n], work)
    return found[:, 0]


Progress = Callable[[str, int, int], None]
JUDGES = ("forward-difference", "central-difference", "complex-step")
"""Methods that the gradients are compared with, from the roughest to the finest."""
AFFORDABLE = 20_000
"""Steps x unknowns x variables up to which a report takes a complex step without being asked: some seconds of plain Python."""
PATIENCE = 20.0
"""Seconds that differences may take without being asked for, by the time of one run."""


@dataclass(frozen=True)
class ReportMaterial:
    """Motion or equilibrium and everything that was computed about it.

    judges : method -> result of the same gradients by other means; empty if nothing was run to compare
    certificate : how far exact methods agree, where a complex step is affordable
    """

    solution: Solution
    results: Results
    judges: Mapping[str, Run] = field(default_factory=dict)
    certificate: Certificate | None = None

    @property
    def scene(self) -> ResolvedScene:
        """Scene that was solved."""
        return self.solution.system.scene

    @property
    def moving(self) -> bool:
        """Whether the solution has more than one time."""
        return self.solution.steps > 0

    @property
    def skins(self) -> list[str]:
        """Names of the flexible bodies that can be drawn."""
        return list(self.look.thickness)

    @cached_property
    def shown(self) -> list[int]:
        """Steps of moving pictures: evenly spread, both ends among them."""
        return spread(self.solution.steps, MOST_FRAMES)

    @cached_property
    def telling(self) -> list[int]:
        """Steps of pictures beside each other, the last among them: those at which something happens."""
        return chosen_steps(self.solution, lambda step: drawn_points(self.moment(step)), None)

    @cached_property
    def look(self) -> Look:
        """Window and colours that all pictures share."""
        return replace(choose_look(self.solution, self.shown), detail=None)

    def moment(self, step: int) -> Configuration:
        """Solution at one step, for drawing; -1 is the last."""
        return Configuration(self.solution, range(len(self.solution.times))[step])

    @cached_property
    def monitors(self) -> Monitors:
        """Energy and drift over time."""
        return monitor(self.solution)


def judge(material: ReportMaterial, progress: Progress, everything: bool = False) -> ReportMaterial:
    """Material with the gradients of numerical methods: of all on request, else of those that take seconds.

    Without that request a method is also left out that needs other numbers than the files of reduced models hold.

    Raises
    ------
    ToolkitError
        A method that was asked for could not be run; says why.
    """
    names = list(material.results.variables)
    kind: Kind = "transient" if material.moving else "static"
    if not names:
        return material

    def run(method: str) -> Run:
        return numerical(material.scene, names, kind, method, lambda done, total: progress(method, done, total), timed=True)

    effort = max(material.solution.steps, 1) * material.solution.system.n * len(names)
    quick = {"complex-step": effort <= AFFORDABLE}
    seconds = material.results.run["wall_primal"] or 0.0
    runs = {"forward-difference": len(names) + 1, "central-difference": 2 * len(names) + 1}
    affordable = [method for method in JUDGES if everything or quick.get(method, seconds * runs.get(method, 0) <= PATIENCE)]
    judges = {}
    for method in affordable:
        try:
            judges[method] = run(method)
        except InputError:
            if everything:
                raise
    return ReportMaterial(material.solution, material.results, judges, _certificate(material, kind, judges, progress))


def _certificate(material: ReportMaterial, kind: Kind, judges: Mapping[str, Run], progress: Progress) -> Certificate | None:
    """Certificate of gradients from direct differentiation, where a complex step was affordable; None otherwise."""
    results, stepped = material.results, judges.get("complex-step")
    if stepped is None or results.method != "direct" or not results.gradients:
        return None
    exact = Run(results.responses, results.response_units, results.gradients, "direct", material.solution, 0.0, 0.0)
    return compare(exact, kind, stepped.gradients, lambda done, total: progress("certificate", done, total))
