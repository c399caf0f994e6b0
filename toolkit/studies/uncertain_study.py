"""A study whose numbers are uncertain: checked, with the distributions of its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.distributions import JointDistribution, Uncertainty, joint_of, marginal_of
from toolkit.studies.orthonormal_basis import scrambled
from toolkit.studies.problem import Problem, problem_of_all
from toolkit.studies.study_file import Study, StudyVariable


@dataclass(frozen=True)
class UncertainStudy:
    """A checked study of uncertain numbers.

    Attributes
    ----------
    problem
        Problem whose variables are the uncertain numbers.
    joint
        Joint distribution of these numbers.
    """

    problem: Problem
    joint: JointDistribution

    @property
    def options(self) -> Uncertainty:
        """Options of how the uncertain responses are found."""
        return self.problem.study.uncertainty

    @cached_property
    def germs(self) -> np.ndarray:
        """Germs of the designs with gradients, (runs, n).

        The first is the one of all means, the others are points of Sobol's sequence.
        """
        scattered = self.joint.germs_of(scrambled(self.options.runs - 1, len(self.joint.marginals), self.options.seed))
        return np.vstack([self.joint.germs_at_mean(), scattered])

    @cached_property
    def designs(self) -> np.ndarray:
        """Uncertain numbers of the designs with gradients, (runs, n)."""
        return np.vstack([self.joint.mean, self.joint.numbers(self.germs[1:])])

    @cached_property
    def random_germs(self) -> np.ndarray:
        """Germs of the random designs, (monte_carlo, n): a larger number of them leaves the first ones unchanged."""
        shares = np.random.default_rng([self.options.seed, 1]).random((self.options.monte_carlo, len(self.joint.marginals)))
        return self.joint.germs_of(shares)

    @cached_property
    def random_designs(self) -> np.ndarray:
        """Uncertain numbers of the random designs, (monte_carlo, n)."""
        return self.joint.numbers(self.random_germs)


def uncertain_study(study: Study, scene: Scene | None = None) -> UncertainStudy:
    """A study with its scene and the distributions of its numbers.

    Raises
    ------
    InputError
        No number is uncertain, a name is unknown, or something contradicts something else.
    """
    if not isinstance(study, Study):
        raise InputError(f"a study is what `read_study` returns, or a Study made in Python, not {type(study).__name__}.")
    if not study.uncertain:
        raise InputError(
            "uncertain is empty: write [uncertain] with numbers of the scene and their distributions, for example "
            't_w = { distribution = "normal", sigma = 0.05 }.'
        )
    anywhere = {
        name: StudyVariable(between=(0.0, 1.0), of=each.of, factors=each.factors) for name, each in study.uncertain.items()
    }
    problem = problem_of_all(
        study.model_copy(update={"variables": anywhere}), scene, study.uncertainty.responses, "uncertainty.responses", "uncertain"
    )
    own = dict(zip(problem.variables, map(float, problem.start), strict=True))
    marginals = {name: marginal_of(name, each, own[name]) for name, each in study.uncertain.items()}
    return UncertainStudy(problem, joint_of(problem.variables, marginals, study.uncertainty.correlations))
