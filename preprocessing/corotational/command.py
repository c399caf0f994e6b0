"""The program behind `ffrf check-deformation`: bodies that were deformed linearly, solved again with corotational elements.

`python -m preprocessing.corotational.command`; its input is a JSON list of bodies, the fields of `Body`, its output one of `Comparison`.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from preprocessing.corotational.elements import Corotational
from preprocessing.corotational.solve import solve_corotational
from preprocessing.mesh.curve_mesh import CurveMesh
from toolkit.foundation.errors import ToolkitError


@dataclass(frozen=True)
class Body:
    """A chain of beam elements and its linear displacement; lists of numbers."""

    nodes: list
    connectivity: list
    modulus: list  # of each element, as thickness and width
    thickness: list
    width: list
    held: list  # (m, n) rows that tie the frame to the body
    displacements: list  # (n,) linear, in the body's frame
    loaded: list | None = None  # (n,) the same without what its spin keeps back; None where it keeps nothing


@dataclass(frozen=True)
class Comparison:
    """Linear against corotational elements under the same forces; the largest of all nodes or stress points."""

    displacement: float  # linear
    error: float  # distance of a node between the two
    stress: float  # linear, largest magnitude
    corotational_stress: float
    stress_error: float  # difference at one stress point


def compare(body: Body) -> Comparison:
    """Solve one body.

    The forces are those that its linear elements need for the displacements without its spin, F = K u: joint forces, loads and, in
    motion, inertia and damping of the body, as far as its basis resolves them, in the directions that they have in the body's frame.

    Raises
    ------
    InputError
        No corotational equilibrium exists under these forces.
    """
    fields = {name: np.array(value) for name, value in asdict(body).items()}
    frame = Corotational(
        CurveMesh(fields["nodes"], fields["connectivity"]), fields["modulus"], fields["thickness"], fields["width"]
    )
    linear, rest = fields["displacements"], np.zeros(len(fields["displacements"]))
    at_rest = frame.tangent(rest)
    found = solve_corotational(frame, at_rest @ (linear if body.loaded is None else fields["loaded"]), fields["held"])
    stress, true = linear_stress(frame, linear), frame.stress(found)
    return Comparison(
        _largest(linear), _largest(found - linear), *(float(np.abs(each).max()) for each in (stress, true, true - stress))
    )


def linear_stress(frame: Corotational, u: np.ndarray) -> np.ndarray:
    """Stress of the linear elements, (n_e, 2, 2) as `Corotational.stress`: its derivative at rest."""
    return frame.stress(1e-30j * u).imag / 1e-30


def _largest(u: np.ndarray) -> float:
    return float(np.hypot(u[0::3], u[1::3]).max())


def main() -> None:
    """Compare all bodies; an error becomes one message and exit code 1."""
    bodies: list[dict[str, Any]] = json.load(sys.stdin)
    try:
        print(json.dumps([asdict(compare(Body(**body))) for body in bodies]))
    except ToolkitError as error:
        print(error, file=sys.stderr)
        raise SystemExit(1) from None


if __name__ == "__main__":
    main()
