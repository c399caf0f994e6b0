"""Signs of shapes that follow the design, against references that share nothing with their code.

Closed forms of bars and of turning eigenvectors; and complex steps through dense systems of textbooks, with the eigenvectors by
Newton's method. Nothing here is a mesh, and nothing is built afresh: `test_bases`, `test_solids` and others compare with rebuilt models.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict

import numpy as np
import pytest
from scipy import sparse

from preprocessing.elements.beams import PlanarBeam
from preprocessing.elements.section import Section, distribute
from preprocessing.reduction.basis import BasisChoice
from preprocessing.reduction.constrained_pencil import ConstrainedPencil
from preprocessing.reduction.discretisation import DesignSpace, Discretisation
from preprocessing.reduction.normal_modes import normal_modes, subspace_rates
from preprocessing.reduction.reduced import reduce
from preprocessing.reduction.solid_basis import SolidShapes, solid_shapes
from preprocessing.reduction.solid_systems import BasisChange, HeldSystem, factored
from preprocessing.reduction.ties import Freedom, NodeTie
from toolkit.reduced_model.model import place_parameter

STEP = 1e-30
EXACT = 1e-9
"""Relative. The conjugate gradients of the modes stop at 1e-11, and the random matrices here multiply that by less than 100."""


def random_stiffness(rng: np.random.Generator, n: int) -> np.ndarray:
    """Positive definite, with a condition below 10."""
    half = rng.normal(size=(n, n))
    return half @ half.T + n * np.eye(n)


def symmetric(rng: np.random.Generator, n: int) -> np.ndarray:
    half = rng.normal(size=(n, n))
    return half + half.T


def rate(value: np.ndarray) -> np.ndarray:
    """What a complex step left."""
    return np.imag(value) / STEP


def close(found: np.ndarray, expected: np.ndarray) -> None:
    """Equal to round-off of the largest entry."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=EXACT * np.abs(expected).max())


def bordered(above: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return np.block([[above, rows.T], [rows, np.zeros((len(rows), len(rows)))]])


def eigenvector(stiffness: np.ndarray, mass: np.ndarray, rows: np.ndarray, start: np.ndarray) -> np.ndarray:
    """phi of K phi - lambda M phi + R^T eta = 0, R phi = 0, phi^T M phi = 1 near a start, by Newton's method; complex as its arguments."""
    phi, value = start.astype(complex), start @ stiffness.real @ start / (start @ mass.real @ start)
    eta = np.linalg.lstsq(rows.real.T, -(stiffness.real - value * mass.real) @ start, rcond=None)[0].astype(complex)
    for _ in range(6):
        left = stiffness - value * mass
        residual = np.concatenate([left @ phi + rows.T @ eta, [(phi @ mass @ phi - 1) / 2], rows @ phi])
        matrix = bordered(left, np.vstack([phi @ mass, rows]))
        matrix[: len(phi), len(phi)] = -(mass @ phi)
        step = np.linalg.solve(matrix, residual)
        phi, value, eta = phi - step[: len(phi)], value - step[len(phi)], eta - step[len(phi) + 1 :]
    return phi


def outside(span: np.ndarray, mass: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """The part of rates that leaves a span of orthonormal shapes: the rest is felt by no response of the reduced body."""
    return rates - span @ (span.T @ mass @ rates)


class RandomBody:
    """Matrices of no body in particular, with rates: 11 coordinates that are free, and the three motions of a rigid tie."""

    n, points = 14, ("mid", "grip", "tip")  # grip is rigid, in the middle of the order

    def __init__(self, rng: np.random.Generator) -> None:
        self.stiffness, self.mass = random_stiffness(rng, self.n), random_stiffness(rng, self.n)
        self.rows = {name: rng.normal(size=(3, self.n)) for name in ("mid", "tip")}
        self.d_stiffness, self.d_mass = symmetric(rng, self.n), symmetric(rng, self.n)
        self.d_rows = {name: rng.normal(size=(3, self.n)) for name in ("mid", "tip")}

    def shapes(self, choice: BasisChoice) -> SolidShapes:
        grip = np.eye(self.n)[-3:]
        ties = {
            name: NodeTie(np.arange(2), np.zeros(2), sparse.csr_array(self.rows.get(name, grip)), name == "grip")
            for name in self.points
        }
        freedom = Freedom(sparse.csr_array(np.eye(self.n)), ("grip",), 3)
        matrices = (sparse.csr_array(each) for each in (self.mass, self.stiffness))
        return solid_shapes(choice, *matrices, np.zeros((self.n, 3)), np.zeros((self.n, 2)), freedom, ties)

    def change(self) -> BasisChange:
        rows = np.vstack([self.d_rows["mid"], self.d_rows["tip"]])
        return BasisChange(*(sparse.csr_array(each) for each in (self.d_stiffness, self.d_mass, rows)))

    def stepped(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness, mass and rows of the averaged points with a complex step."""
        rows = [self.rows[name] + 1j * STEP * self.d_rows[name] for name in ("mid", "tip")]
        return self.stiffness + 1j * STEP * self.d_stiffness, self.mass + 1j * STEP * self.d_mass, np.vstack(rows)

    def constraint_modes(self) -> np.ndarray:
        """Least energy for a unit motion of one point with all others held, by one bordered system of all coordinates; complex."""
        stiffness, _, averaged = self.stepped()
        rows = np.vstack([averaged[:3], np.eye(self.n)[-3:], averaged[3:]])
        below = np.vstack([np.zeros((self.n, 9)), np.eye(9)])
        return np.linalg.solve(bordered(stiffness, rows), below)[: self.n]


@pytest.fixture
def body() -> RandomBody:
    return RandomBody(np.random.default_rng(3))


@pytest.mark.parametrize("kind", ["static", "craig-bampton"])
def test_constraint_modes_of_solids_and_their_rates_by_a_bordered_system(body, kind):
    shapes = body.shapes(BasisChoice(kind, count=2 if kind == "craig-bampton" else None))
    expected = body.constraint_modes()
    close(shapes.columns[:, :9], expected.real)
    close(shapes.rates(body.change())[:, :9], rate(expected))


def test_rates_of_fixed_interface_modes_of_solids_by_newtons_method(body):
    """The interface, averaged and rigid, holds the modes; the averaged rows change."""
    shapes = body.shapes(BasisChoice("craig-bampton", count=2))
    stiffness, mass, rows = body.stepped()
    held, phi = slice(0, body.n - 3), shapes.columns[:-3, 9:]
    reference = [eigenvector(stiffness[held, held], mass[held, held], rows[:, held], column) for column in phi.T]
    close(phi, np.real(reference).T)
    found = shapes.rates(body.change())[:, 9:]
    close(found[:-3], outside(phi, body.mass[held, held], rate(np.array(reference).T)))
    assert not found[-3:].any()


def test_rates_of_modes_of_a_free_solid_by_newtons_method():
    """Stiffness without resistance to three motions, which change with the design as the stiffness and the mass do."""
    rng = np.random.default_rng(4)
    n, core, mass = 14, random_stiffness(rng, 14), random_stiffness(rng, 14)
    d_core, d_mass, motions, d_motions = symmetric(rng, n), symmetric(rng, n), rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    moved, heavy = motions + 1j * STEP * d_motions, mass + 1j * STEP * d_mass
    strain = np.eye(n) - moved @ np.linalg.solve(moved.T @ moved, moved.T)
    stiffness = strain.T @ (core + 1j * STEP * d_core) @ strain
    matrices = (sparse.csr_array(each) for each in (mass, stiffness.real))
    freedom = Freedom(sparse.csr_array(np.eye(n)), (), 3)
    shapes = solid_shapes(BasisChoice("eigenmodes", "free", count=2), *matrices, motions, np.zeros((n, 2)), freedom, {})
    phi = shapes.columns
    reference = np.array([eigenvector(stiffness, heavy, moved.T @ heavy, column) for column in phi.T]).T
    close(phi, reference.real)
    found = shapes.rates(BasisChange(sparse.csr_array(rate(stiffness)), sparse.csr_array(d_mass), None, d_motions))
    close(found, outside(phi, mass, rate(reference)))


def test_rates_of_modes_of_skins_by_newtons_method():
    """Under rows that change, with a mass that changes."""
    rng = np.random.default_rng(6)
    n, rows, d_rows = 12, rng.normal(size=(3, 12)), rng.normal(size=(3, 12))
    stiffness, mass, change = random_stiffness(rng, n), random_stiffness(rng, n), (symmetric(rng, n), symmetric(rng, n), d_rows)
    modes = normal_modes(ConstrainedPencil(stiffness, mass, rows), 2)
    stepped = [value + 1j * STEP * d for value, d in zip((stiffness, mass, rows), change, strict=True)]
    reference = np.array([eigenvector(*stepped, column) for column in modes.columns.T]).T
    close(modes.columns, reference.real)
    found = modes.turned(subspace_rates(modes, [ConstrainedPencil(*change)]))[:, :, 0]
    close(outside(modes.columns, mass, found), outside(modes.columns, mass, rate(reference)))


def test_a_refinement_squares_the_error_of_the_factors():
    """Factors of a matrix that is off by 1e-5 leave 1e-10."""
    rng = np.random.default_rng(7)
    stiffness, force = random_stiffness(rng, 9), rng.normal(size=(9, 2))
    exact = sparse.csr_array(stiffness)
    system = HeldSystem(exact, sparse.csr_array((0, 9)), factored(exact * (1 + 1e-5), None), np.zeros((9, 0)), None)
    expected = np.linalg.solve(stiffness, force)
    np.testing.assert_allclose(system.solve(force), expected * (1 - 1e-10), rtol=0, atol=1e-13 * np.abs(expected).max())


def bar(ends: np.ndarray) -> np.ndarray:
    """Stiffness of a bar of unit EA that is held at 0, with nodes at `ends`."""
    springs = 1 / np.diff(ends, prepend=0.0)
    matrix = np.diag(springs).astype(springs.dtype)
    matrix[:-1, :-1] += np.diag(springs[1:])
    return matrix - np.diag(springs[1:], 1) - np.diag(springs[1:], -1)


ENDS, PULL = np.array([0.3, 0.5, 1.1, 1.6, 1.9]), np.array([0.2, -0.1, 0.4, 0.3, -0.2])
"""Nodes of a bar, and how they move with the design."""


@pytest.mark.parametrize("tie", ["rigid", "averaged"])
def test_the_pulled_bar_is_that_of_the_closed_form(tie):
    """u = x / L for a node that is held; for the mean with the weights 1 - w and w of the last two nodes, at a and a + h, the force
    1 / (a + w^2 h) stretches all elements but the last one, and w times that the last one."""
    weight, d_weight = 0.3, 0.7
    x, w = ENDS + 1j * STEP * PULL, weight + 1j * STEP * d_weight
    a, h = x[-2], x[-1] - x[-2]
    expected = x / x[-1] if tie == "rigid" else np.append(x[:-1], a + w * h) / (a + w**2 * h)
    rows, d_rows = np.zeros((1, 5)), np.zeros((1, 5))
    rows[0, -2:], d_rows[0, -2:] = ([0, 1], [0, 0]) if tie == "rigid" else ([1 - weight, weight], [-d_weight, d_weight])
    freedom = Freedom(sparse.csr_array(np.eye(5)), ("tip",) if tie == "rigid" else (), 1)
    tip = NodeTie(np.arange(2), np.zeros(2), sparse.csr_array(rows), tie == "rigid")
    matrices = (sparse.csr_array(each) for each in (np.eye(5), bar(ENDS)))
    shapes = solid_shapes(BasisChoice("static"), *matrices, np.zeros((5, 1)), np.zeros((5, 2)), freedom, {"tip": tip})
    close(shapes.columns[:, 0], expected.real)
    change = BasisChange(sparse.csr_array(rate(bar(x))), None, None if tie == "rigid" else sparse.csr_array(d_rows))
    close(shapes.rates(change)[:, 0], rate(expected))


def by_solids(stiffness: np.ndarray, d_stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first mode of a solid of unit mass, and its rate."""
    freedom = Freedom(sparse.csr_array(np.eye(2)), (), 3)
    matrices = (sparse.csr_array(each) for each in (np.eye(2), stiffness))
    shapes = solid_shapes(BasisChoice("eigenmodes", count=1), *matrices, np.zeros((2, 3)), np.zeros((2, 2)), freedom, {})
    return shapes.columns[:, 0], shapes.rates(BasisChange(sparse.csr_array(d_stiffness)))[:, 0]


def by_skins(stiffness: np.ndarray, d_stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same of a skin."""
    modes = normal_modes(ConstrainedPencil(stiffness, np.eye(2), np.zeros((0, 2))), 1)
    change = ConstrainedPencil(d_stiffness, np.zeros((2, 2)), np.zeros((0, 2)))
    return modes.columns[:, 0], modes.turned(subspace_rates(modes, [change]))[:, 0, 0]


def turning(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness with the first eigenvector (cos, sin) of the angle, and its rate by the angle."""
    c, s = np.cos(angle), np.sin(angle)
    turn, d_turn = np.array([[c, -s], [s, c]]), np.array([[-s, -c], [c, -s]])
    half = d_turn @ np.diag([1.0, 3.0]) @ turn.T
    return turn @ np.diag([1.0, 3.0]) @ turn.T, half + half.T


@pytest.mark.parametrize("mode", [by_solids, by_skins])
def test_the_rate_of_a_mode_has_the_sign_that_the_mode_is_told_with(mode: Callable):
    """The first mode turns by half a circle. On the way its strongest entry changes place twice, and its sign with it at one of them:
    then the rate changes its sign too, and everywhere else it is the slope of the columns that stand in files."""
    angles, delta, signs = np.linspace(0.02, np.pi - 0.02, 41), 1e-4, []
    for angle in angles:
        (column, slope), ahead, behind = mode(*turning(angle)), mode(*turning(angle + delta))[0], mode(*turning(angle - delta))[0]
        sign = np.sign(column @ [np.cos(angle), np.sin(angle)])
        signs.append(sign)
        close(column, sign * np.array([np.cos(angle), np.sin(angle)]))
        close(slope, sign * np.array([-np.sin(angle), np.cos(angle)]))
        np.testing.assert_allclose(
            (ahead - behind) / (2 * delta), slope, atol=delta**2 + 1e-11
        )  # error delta^2 / 6, and round-off
    assert np.flatnonzero(np.diff(signs)).size == 1
    assert angles[np.flatnonzero(np.diff(signs))[0]] > np.pi / 2  # where one entry is negative


SECTION = Section(2e11, 7800.0, 0.02, 0.05)
NODES = np.array([0.0, 0.3, 0.5, 0.9, 1.0])


def textbook_beam() -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass of a straight Euler-Bernoulli beam along x, with (u, w, turn) at each node; consistent mass."""
    area, moment = SECTION.thickness * SECTION.width, SECTION.width * SECTION.thickness**3 / 12
    stiffness, mass = np.zeros((2, 3 * len(NODES), 3 * len(NODES)))
    for k, h in enumerate(np.diff(NODES)):
        along, across = [3 * k, 3 * k + 3], [3 * k + 1, 3 * k + 2, 3 * k + 4, 3 * k + 5]
        bending = [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
        inertia = [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h * h, 13 * h, -3 * h * h],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
        ]
        heavy = SECTION.density * area * h
        stiffness[np.ix_(along, along)] += SECTION.youngs_modulus * area / h * np.array([[1, -1], [-1, 1]])
        stiffness[np.ix_(across, across)] += SECTION.youngs_modulus * moment / h**3 * np.array(bending)
        mass[np.ix_(along, along)] += heavy / 6 * np.array([[2, 1], [1, 2]])
        mass[np.ix_(across, across)] += heavy / 420 * np.array(inertia)
    return stiffness, mass


def rows_at(place: complex) -> np.ndarray:
    """Displacement and rotation at a place within an element, by linear and Hermite interpolation."""
    k = int(np.searchsorted(NODES, np.real(place))) - 1
    h, rows = NODES[k + 1] - NODES[k], np.zeros((3, 3 * len(NODES)), complex)
    t = (place - NODES[k]) / h
    rows[0, [3 * k, 3 * k + 3]] = 1 - t, t
    across = [3 * k + 1, 3 * k + 2, 3 * k + 4, 3 * k + 5]
    rows[1, across] = 1 - 3 * t**2 + 2 * t**3, h * (t - 2 * t**2 + t**3), 3 * t**2 - 2 * t**3, h * (t**3 - t**2)
    rows[2, across] = (6 * t**2 - 6 * t) / h, 1 - 4 * t + 3 * t**2, (6 * t - 6 * t**2) / h, 3 * t**2 - 2 * t
    return rows


@pytest.mark.parametrize("moved", ["near", "far"])
@pytest.mark.parametrize("choice", [BasisChoice("static"), BasisChoice("craig-bampton", count=2)], ids=lambda choice: choice.kind)
def test_shapes_follow_the_place_of_a_point_in_the_direction_in_which_it_moves(choice, moved):
    places = {"near": 0.42, "far": 0.87}
    parameters, chain = distribute(asdict(SECTION), {}, (), 4), np.column_stack([np.arange(4), np.arange(1, 5)])
    beams = PlanarBeam(np.column_stack([NODES, 0 * NODES]), chain, parameters.patches)
    discrete = Discretisation(beams, places, NODES)
    space = DesignSpace(parameters.values, parameters.quantities, frozenset(parameters.values), lambda _: discrete)
    found = reduce(space, choice, 0, "the first node")
    change = found.space.change(found.space.nominal(), place_parameter(moved))
    rates = found.basis.rates([change.rates])[:, 1:, 0]

    stepped = [place + 1j * STEP * (name == moved) for name, place in places.items()]
    stiffness, mass = textbook_beam()
    rows = np.vstack([np.eye(15)[:3], *(rows_at(place) for place in stepped)])
    expected = np.linalg.solve(bordered(stiffness / stiffness.max(), rows), np.vstack([np.zeros((15, 9)), np.eye(9)]))[:15, 3:]
    close(found.basis.z[:, 1:7], expected.real)
    close(rates[:, :6], rate(expected))
    if choice.count:
        phi, scale = found.basis.z[:, 7:], stiffness.max() / mass.max()
        reference = np.array([eigenvector(stiffness / scale, mass, rows, column) for column in phi.T]).T
        close(phi, reference.real)
        close(outside(phi, mass, rates[:, 6:]), outside(phi, mass, rate(reference)))
    own = found.derivatives[f"interfaces.{moved}.arc_length"]
    assert own.value == pytest.approx([1.0], abs=1e-15)
    assert list(found.space.values)[own.parameter[0]] == place_parameter(moved)
