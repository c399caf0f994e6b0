"""How right `ffrf uncertainty` is about the morphing wing, against plain Monte Carlo: python -m tests.benchmarks.uncertain_wing [ROWS]

Every row solves the wing at two independent random designs, and at five between them (Saltelli's scheme for Sobol's indices), from the
equilibrium at the means; 14286 rows are 100002 runs, and take three quarters of an hour of a busy core.

Errors are told twice: against the runs as they are, and with the polynomials of the 20 runs as a control variate, which are asked about the
same random designs, and whose own mean, sigma and indices are known:

    error = (estimate by the polynomials - estimate by the runs) at the same designs

Its expectation is the error itself, whatever the polynomials are, and the luck of the random designs is nearly left out of it. What
stands behind +- are standard errors by the bootstrap over rows.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from toolkit.studies.design_work import DesignJob, DesignWork
from toolkit.studies.find_uncertainty import find_uncertainty
from toolkit.studies.solved_design import solve_design
from toolkit.studies.study_file import read_study
from toolkit.studies.uncertain_study import uncertain_study

STUDY = Path(__file__).parents[2] / "models" / "morphing_wing" / "study.toml"


RESAMPLED = 200
"""Sets of rows that standard errors are found from; they are known to a twentieth then."""


def statistics(values: np.ndarray) -> np.ndarray:
    """Mean, sigma and Sobol's indices, first the n of each number alone, then the n total ones, of values (rows, 2 + n)."""
    one, other, mixed = values[:, :1], values[:, 1:2], values[:, 2:]
    mean, variance = np.mean(values[:, :2]), np.var(values[:, :2])
    alone = np.mean((other - mean) * (mixed - one), axis=0) / variance
    together = np.mean((one - mixed) ** 2, axis=0) / (2 * variance)
    return np.array([mean, np.sqrt(variance), *alone, *together])


def compared(exact: np.ndarray, polynomials: np.ndarray, values: np.ndarray) -> str:
    """Errors of exact statistics of the polynomials, by the runs (rows, 2 + n), and by these and the polynomials at the same designs."""
    rng = np.random.default_rng(1)
    chosen = [np.arange(len(values)), *rng.integers(len(values), size=(RESAMPLED, len(values)))]
    runs, same = (np.array([statistics(each[rows]) for rows in chosen]) for each in (values, polynomials))
    return "; with the control variate: ".join(_said(each, runs[0]) for each in (exact - runs, same - runs))


def _said(errors: np.ndarray, size: np.ndarray) -> str:
    """Of errors (1 + RESAMPLED, statistics): relative ones of mean and sigma, and of the indices the largest with its standard error."""
    spread = np.std(errors[1:], axis=0)
    mean, sigma = (f"{100 * errors[0, k] / size[k]:.2g} +- {100 * spread[k] / size[k]:.1g} %" for k in (0, 1))
    worst = 2 + int(np.argmax(np.abs(errors[0, 2:])))
    return f"mean {mean}, sigma {sigma}, indices {abs(errors[0, worst]):.1g} +- {spread[worst]:.1g}"


def main(rows: int) -> None:
    """Print errors of mean, sigma and indices, and what the result says of its own error."""
    study = read_study(STUDY)
    wing = uncertain_study(study.model_copy(update={"constraints": {}}))
    found, n = find_uncertainty(wing), len(wing.joint.marginals)
    work = DesignWork(wing.problem, solve_design(wing.problem, 0, wing.designs[0], None))
    one, other = np.random.default_rng(20261123).random((2, rows, n))
    points = np.stack([one, other, *(np.where(np.arange(n) == k, other, one) for k in range(n))], axis=1)
    germs = wing.joint.germs_of(points.reshape(-1, n))
    runs = [work(DesignJob(1, design, False)) for design in wing.joint.numbers(germs)]
    print(f"{len(runs)} runs, {sum(each.failed for each in runs)} failed; {found.said}")
    for k, (name, spread) in enumerate(found.responses.items()):
        values = np.array([each.values[0, k] for each in runs]).reshape(rows, -1)
        assert spread.alone is not None
        assert spread.together is not None
        exact = np.array([spread.mean, spread.sigma, *spread.alone.values(), *spread.together.values()])
        said = compared(exact, found.values(name, germs).reshape(rows, -1), values)
        print(f"{name}: {said}; left out {spread.left_out:.1e}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 14286)
