"""Derivatives of the span of the kept modes against the resolvent's contour integral and differences of fresh solutions."""

from dataclasses import replace

import numpy as np
import pytest

from preprocessing.reduction.constrained_pencil import ConstrainedPencil
from preprocessing.reduction.normal_modes import normal_modes, subspace_rates
from tests.models.frames import cantilever, pencil_rate, relative, richardson, ring, square, varied, wing
from toolkit.foundation.errors import InputError

POINT = {"P": 7.37}
CASES = {
    "free ring": (ring(24, 100.0), None, 6),
    "free square": (square(6), None, 6),
    "free skin": (wing(), None, 8),
    "clamped skin": (wing(), "clamp", 8),
    "skin with a point held inside an element": (replace(wing(), points=POINT), "point", 7),
}
"""Frame, what holds it, number of modes; ring and square have equal eigenvalues among those kept."""


def rows(frame, held):
    n = 3 * len(frame.nodes)
    if held is None:
        return np.zeros((0, n))
    return np.vstack([np.eye(n)[:3], *(frame.interface_rows().values() if held == "point" else [])])


def rate(frame, held, variable) -> ConstrainedPencil:
    d = pencil_rate(frame, variable)
    d_rows = np.asarray(rows(varied(frame, variable, 1e-30j), held)).imag / 1e-30
    return ConstrainedPencil(d.stiffness, d.mass, d_rows)


def projector(modes) -> np.ndarray:
    """P = Phi Phi^T M, the same for every basis of the span."""
    return modes.shapes @ modes.shapes.T @ modes.pencil.mass


def projector_rate(modes, d_phi, d) -> np.ndarray:
    phi, mass = modes.shapes, modes.pencil.mass
    return d_phi @ phi.T @ mass + phi @ d_phi.T @ mass + phi @ phi.T @ d.mass


def contour(modes, changes, n_points: int = 320) -> list[np.ndarray]:
    """dP from dG = -G (dA) G of the bordered resolvent G(z) = [K - z M, R^T; R, 0]^-1, integrated round the kept eigenvalues.

        P = -1 / (2 pi i) int G(z) M dz,    the trapezoidal rule on a smooth curve converges exponentially

    No mode and no gap between eigenvalues enters but those that the curve separates. It is an ellipse in log z, because the
    eigenvalues spread over decades; its lower half gives the conjugate of the upper one.
    """
    pencil, n = modes.pencil, len(modes.shapes)
    low, high = 0.3 * modes.eigenvalues[0], np.sqrt(modes.eigenvalues[-1] * modes.discarded[0])
    radius, height = np.log(high / low) / 2, 0.6
    angle = 2 * np.pi * (np.arange(n_points // 2) + 0.5) / n_points
    place = np.sqrt(low * high) * np.exp(radius * np.cos(angle) + 1j * height * np.sin(angle))
    weight = place * (-radius * np.sin(angle) + 1j * height * np.cos(angle)) * 2 / (1j * n_points)
    scale = 1 / np.sqrt(np.diag(pencil.stiffness))
    size = np.concatenate([scale, 1 / np.linalg.norm(pencil.rows * scale, axis=1)])
    totals = [np.zeros((n, n)) for _ in changes]
    for z, w in zip(place, weight, strict=True):
        resolvent = size[:, None] * np.linalg.inv(size[:, None] * bordered(pencil, z) * size) * size
        for total, d in zip(totals, changes, strict=True):
            turned = (resolvent @ bordered(d, z) @ resolvent)[:n, :n] @ pencil.mass
            total += (w * (turned - resolvent[:n, :n] @ d.mass)).real
    return totals


def bordered(pencil, z: complex) -> np.ndarray:
    zero = np.zeros((len(pencil.rows),) * 2)
    return np.block([[pencil.stiffness - z * pencil.mass, pencil.rows.T], [pencil.rows, zero]])


def variables(held) -> list[str]:
    return ["thickness", "density", "element", "shape", *(["place"] if held == "point" else [])]


PAIRS = [(case, variable) for case, (_, held, _) in CASES.items() for variable in variables(held)]


@pytest.mark.parametrize("case", CASES)
def test_derivatives_of_the_projector_are_contour_integrals(case):
    frame, held, count = CASES[case]
    changes = [rate(frame, held, variable) for variable in variables(held)]
    modes = normal_modes(ConstrainedPencil(*frame.matrices(), rows(frame, held)), count)
    found = subspace_rates(modes, changes)
    for x, (d, reference) in enumerate(zip(changes, contour(modes, changes), strict=True)):
        scale = max(np.abs(reference).max(), np.abs(projector(modes)).max())
        difference = np.abs(projector_rate(modes, found[:, :, x], d) - reference).max()
        assert difference < 1e-7 * scale  # round-off of dK times lambda_n / lambda_1, up to 1e8


@pytest.mark.parametrize(("case", "variable"), PAIRS)
def test_derivative_of_the_projector_agrees_with_fresh_solutions(case, variable):
    frame, held, count = CASES[case]

    def fresh(step):
        changed = varied(frame, variable, step)
        return projector(normal_modes(ConstrainedPencil(*changed.matrices(), rows(changed, held)), count))

    d = rate(frame, held, variable)
    modes = normal_modes(ConstrainedPencil(*frame.matrices(), rows(frame, held)), count)
    ours = projector_rate(modes, subspace_rates(modes, [d])[:, :, 0], d)
    scale = max(np.abs(ours).max(), np.abs(projector(modes)).max())
    # order 8 of the extrapolation, and round-off of fresh solutions (1e-9) over the smallest step
    assert np.abs(ours - richardson(fresh, 4e-3, 4)).max() < 1e-6 * scale


def test_many_variables_at_once_are_each_of_them_alone():
    frame, held, count = CASES["clamped skin"]
    modes = normal_modes(frame.pencil(rows(frame, held)), count)
    changes = [rate(frame, held, variable) for variable in variables(held)]
    together = subspace_rates(modes, changes)
    for x, change in enumerate(changes):
        assert relative(together[:, :, x], subspace_rates(modes, [change])[:, :, 0]) < 1e-12  # the same factors


def test_the_gauge_keeps_the_modes_orthonormal():
    frame, _, count = CASES["free ring"]
    modes, d = normal_modes(frame.pencil(), count), pencil_rate(frame, "element")
    turned = modes.shapes.T @ modes.pencil.mass @ subspace_rates(modes, [d])[:, :, 0]
    own = modes.shapes.T @ d.mass @ modes.shapes
    np.testing.assert_allclose(turned, -own / 2, rtol=0, atol=1e-12 * np.abs(own).max())  # a row of the system that is solved


def test_no_modes_have_no_derivative_and_no_error():
    frame = cantilever(3)
    assert subspace_rates(normal_modes(frame.pencil(), 0), [pencil_rate(frame, "width")]).shape == (12, 0, 1)


@pytest.mark.parametrize("count", [1, 3])
def test_a_cut_pair_is_refused_with_modes_frequencies_and_remedy(count):
    frame = ring(24, 100.0)
    modes = normal_modes(frame.pencil(), count)
    remedy = "Keep 2 modes" if count == 1 else "Keep 2 or 4 modes"
    with pytest.raises(InputError, match=rf"mode {count} \(.* Hz\) is kept and mode {count + 1} \(.* Hz\) is left out.*{remedy}"):
        subspace_rates(modes, [pencil_rate(frame, "width")])
