"""How right `ffrf uncertainty` is about the morphing wing, against plain Monte Carlo: python -m tests.benchmarks.uncertain_wing [ROWS]

Every row solves the wing at two independent random designs, and at five between them (Saltelli's scheme for Sobol's indices), from the
equilibrium at the means; 14286 rows are 100002 runs, and take three quarters of an hour of a busy core. The polynomials of 20 runs are
compared with the runs at the same designs too, which leaves the error of sampling out.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from toolkit.studies.designs.design_work import Asked, DesignWork
from toolkit.studies.evaluation.solved_design import solved
from toolkit.studies.study.study_reader import read_study
from toolkit.studies.uncertainty.find_uncertainty import found_uncertainty
from toolkit.studies.uncertainty.uncertain_study import uncertain_study

STUDY = Path(__file__).parents[2] / "models" / "morphing_wing" / "study.toml"


def shares(values: np.ndarray) -> np.ndarray:
    """Sobol's indices of the first order and total ones, (2, n), of values (rows, 2 + n)."""
    one, other, mixed = values[:, :1], values[:, 1:2], values[:, 2:]
    mean, variance = np.mean(values), np.var(values)
    alone = np.mean((other - mean) * (mixed - one), axis=0) / variance
    return np.array([alone, np.mean((one - mixed) ** 2, axis=0) / (2 * variance)])


def main(rows: int) -> None:
    """Print errors of mean, sigma and indices, each with the standard error of the Monte Carlo run."""
    study = read_study(STUDY)
    wing = uncertain_study(study.model_copy(update={"constraints": {}}))
    found, n = found_uncertainty(wing), len(wing.joint.marginals)
    work = DesignWork(wing.problem, solved(wing.problem, 0, wing.designs[0], None))
    one, other = np.random.default_rng(20261123).random((2, rows, n))
    points = np.stack([one, other, *(np.where(np.arange(n) == k, other, one) for k in range(n))], axis=1)
    germs = wing.joint.germs_of(points.reshape(-1, n))
    runs = [work(Asked(1, design, False)) for design in wing.joint.numbers(germs)]
    print(f"{len(runs)} runs, {sum(each.failed for each in runs)} failed; {found.said}")
    for k, (name, spread) in enumerate(found.responses.items()):
        values = np.array([each.values[0, k] for each in runs]).reshape(rows, -1)
        polynomials = found.values(name, germs).reshape(rows, -1)
        mean, sigma = np.mean(values), np.std(values)
        errors = np.std(np.mean(values, axis=1)) / mean, np.std(np.mean((values - mean) ** 2, axis=1)) / (2 * sigma**2)
        assert spread.alone is not None
        assert spread.together is not None
        indices = np.array([list(spread.alone.values()), list(spread.together.values())])
        print(
            f"{name}: mean {spread.mean / mean - 1:.1e} +- {errors[0] / rows**0.5:.1e}, sigma {spread.sigma / sigma - 1:.1e} +- "
            f"{errors[1] / rows**0.5:.1e}, indices {np.max(np.abs(indices - shares(values))):.1e}; at the same designs: mean "
            f"{np.mean(polynomials) / mean - 1:.1e}, sigma {np.std(polynomials) / sigma - 1:.1e}, indices "
            f"{np.max(np.abs(shares(polynomials) - shares(values))):.1e}; left out {spread.left_out:.1e}"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 14286)
