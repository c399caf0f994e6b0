"""A study with its scene: everything that can be wrong is found here, before anything is solved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from toolkit.responses.response import MeanSquare, Response
from toolkit.responses.vibrations.vibration import Frequency
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.scene_file.gradient_units import variable_unit
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.preparation import Kind
from toolkit.studies.engine.fingerprint import scene_fingerprint
from toolkit.studies.study.study_file import LOAD_MARGIN, Study
from toolkit.studies.study.uncertain_points import UncertainPoints
from toolkit.studies.study.wanted import (
    OBJECTIVE,
    Statistic,
    Wanted,
    in_norm,
    kind_of,
    limits_of,
    mode_of,
    norm_of,
    statistics_of,
    weights_of,
)

FURTHER, FAR = 2.0, 10.0
"""Times the wanted load margin up to which a limit point is looked for; and load factor up to which, where the margin is the objective."""
ROUND_OFF = 1e-13
"""Relative change of a response that nothing has to have brought about."""
ONLY = ""
"""Name of the only case of a study that names none."""
BUDGET = {"starts", "evaluations"}
"""Options of a search that change how many designs are solved, and no number of any."""
ELSEWHERE = {"search", "directory", "responses", "scene", "uncertain", "sweep", "uncertainty"}
"""Parts of a study that count otherwise in its fingerprint, or say only which designs are solved."""


@dataclass(frozen=True)
class Problem:
    """A checked study.

    Attributes
    ----------
    study
        As it was written.
    scene
        With all responses of scene and study, and with the variables that move several numbers.
    asked
        Responses that objective and constraints look at, without the load margin.
    points
        Of uncertain numbers, at all of which every design is solved; None if nothing is to be robust.
    norms
        Responses of which the norm of the gradient is asked.
    """

    study: Study
    scene: Scene
    asked: tuple[str, ...]
    points: UncertainPoints | None = None
    norms: tuple[str, ...] = ()

    @property
    def kind(self) -> Kind:
        """What is solved for every design."""
        return kind_of(self.study)

    @cached_property
    def modes(self) -> dict[str, int]:
        """Frequencies that are followed by the shapes of their modes -> their number where the scene stands."""
        return {name: number for name in self.asked if (number := mode_of(self.study, name)) is not None}

    @cached_property
    def shapes(self) -> dict[str, np.ndarray]:
        """Case -> shapes of these modes there, (n_q, modes), as far as they were asked for."""
        return {}

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the variables, in the order of all arrays."""
        return tuple(self.study.variables)

    @property
    def cases(self) -> dict[str, dict[str, float]]:
        """Name -> numbers that are others in this case."""
        return self.study.cases or {ONLY: {}}

    @property
    def responses(self) -> tuple[str, ...]:
        """All that is evaluated for a design, in the order of all arrays; the load margin is the last."""
        known = (*self.asked, *map(norm_of, self.norms), *self.statistics)
        return (*known, LOAD_MARGIN) if self.margin_up_to is not None else known

    @cached_property
    def labels(self) -> dict[str, tuple[int, int]]:
        """Response, with its case before it where cases have names -> place of case and response in the values of a design."""
        return {label: (i, j) for j, name in enumerate(self.responses) for i, label in enumerate(by_case(self.cases, name))}

    @cached_property
    def statistics(self) -> dict[str, Statistic]:
        """Name -> mean and deviation over uncertain numbers, as far as something is to be robust."""
        return {} if self.points is None else statistics_of(self.study)

    @cached_property
    def weights(self) -> Mapping[str, float]:
        """What the objective is the weighted sum of."""
        return weights_of(self.study, self.points is not None)

    @cached_property
    def squares(self) -> dict[str, MeanSquare]:
        """Mean squares that are to be small: they tell their curvature, by the derivatives of states that the study's method carries."""
        objective, carried = self.study.objective, self.kind == "static" or self.study.search.gradients == "direct"
        wanted = [name for name, weight in objective.weights.items() if carried and objective.sign * weight > 0]
        known = ((name, self.scene.responses.get(name)) for name in wanted)
        return {name: each for name, each in known if isinstance(each, MeanSquare)}

    @cached_property
    def curved(self) -> tuple[str, ...]:
        """What the objective is the weighted sum of, as far as its curvature is told: mean squares, or what is robust of them."""
        return tuple(name for name in self.weights if self.squares and (name in self.statistics or name in self.squares))

    @cached_property
    def limits(self) -> tuple[Wanted, ...]:
        """All limits."""
        return tuple(limits_of(self.study, self.points is not None))

    @cached_property
    def margin_up_to(self) -> float | None:
        """Load factor up to which a limit point is looked for; None if nobody asks for it."""
        limit, wanted = self.study.constraints.get(LOAD_MARGIN), LOAD_MARGIN in self.study.objective.weights
        largest = max((abs(each) for each in limit.limits if each is not None), default=0.0) if limit else 0.0
        return max(FAR if wanted else FURTHER, FURTHER * largest) if limit or wanted else None

    @cached_property
    def bounds(self) -> np.ndarray:
        """Least and largest value of every variable, (2, n)."""
        return np.array([each.between for each in self.study.variables.values()]).T

    @cached_property
    def scales(self) -> np.ndarray:
        """What a large change of every variable is, (n,)."""
        ranges = self.bounds[1] - self.bounds[0]
        given = [each.scale for each in self.study.variables.values()]
        return np.array([r if s is None else s for r, s in zip(ranges, given, strict=True)])

    @cached_property
    def origin(self) -> np.ndarray:
        """What is added to the value of every variable to make it the scene's number: where it moves several, their present value."""
        moved = (self.scene.value_of(name) if each.of else 0.0 for name, each in self.study.variables.items())
        return np.array([float(each) for each in moved])

    @cached_property
    def start(self) -> np.ndarray:
        """Where the scene stands, (n,)."""
        return np.array([self.scene.value_of(name) for name in self.variables]) - self.origin

    @cached_property
    def compiled(self) -> Compiled:
        """The scene with the responses that are asked for, compiled with its variables."""
        chosen = {name: self.scene.responses[name] for name in self.asked if name not in self.modes}
        return Compiled(self.scene.model_copy(update={"responses": chosen}), self.variables)

    def numbers(self, design: np.ndarray) -> dict[str, float]:
        """Numbers of the scene for a design (n,)."""
        return dict(zip(self.variables, map(float, self.origin + design), strict=True))

    def undecided(self, response: str, values: np.ndarray) -> float:
        """How much of a response of such values round-off may decide: of a place or an angle also what Newton leaves undecided."""
        if (of := in_norm(response)) is not None:
            return self.undecided(of, values)
        if (several := self.statistics.get(response)) is not None:
            return sum(abs(weight) * self.undecided(name, values) for name, weight in several.weights.items())
        described, sizes = self.scene.responses.get(response), {"angle": 1.0, "length": loaded(self.scene).size}
        size = sizes.get(described.unit_quantity, 0.0) if isinstance(described, Response) else 0.0
        return ROUND_OFF * float(np.max(np.abs(values))) + self.scene.solver.tolerance * size

    def unit_of(self, response: str) -> str:
        """Label of the unit of a response."""
        response = self.statistics[response].of if response in self.statistics else in_norm(response) or response
        if response in (LOAD_MARGIN, OBJECTIVE):
            return ""
        if response in self.modes:
            return Frequency().unit(self.scene.units)
        found = self.scene.responses[response]
        return found.unit(self.scene.units) if isinstance(found, Response) else ""

    def unit_of_variable(self, name: str) -> str:
        """Label of the unit of a variable."""
        return variable_unit(self.scene, self.scene.paths_of(name)[0])

    @property
    def fingerprint(self) -> str:
        """Hash of study, scene, the files that it reads, and the program; more starts or evaluations leave it as it is.

        The order of variables, cases and responses counts: a store has arrays in that order.
        """
        study = self.study
        search = {key: value for key, value in study.search.model_dump(mode="json").items() if key not in BUDGET}
        rest = study.model_dump(mode="json", exclude=ELSEWHERE)
        cases = [(name, list(numbers.items())) for name, numbers in self.cases.items()]
        parts: list[Any] = [rest, search, self.variables, cases, self.responses]
        if self.points is not None:
            options = study.uncertainty.model_dump(mode="json", include={"correlations", "points", "seed"})
            parts += [[(name, each.model_dump(mode="json")) for name, each in study.uncertain.items()], options]
        return scene_fingerprint(self.scene, *parts)


def by_case(cases: Iterable[str], name: str) -> list[str]:
    """A response's name in every case: with the case before it where cases have names."""
    return [f"{case}.{name}" if case else name for case in cases]
