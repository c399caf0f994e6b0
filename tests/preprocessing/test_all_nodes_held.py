"""Bodies all of whose nodes are held by a clamp and rigid ties: what moves is the points alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.discrete_body import lame_factors
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.solid_elements import element_blocks
from tests.models.solid_bodies import DENSITY, MODULUS, WIDTH, box, compliance, frequencies, moves, rectangle, write_body
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load, save

pytestmark = pytest.mark.usefixtures("read_here")

BASES = {
    "full": 'kind = "full"',
    "static": 'kind = "static"',
    "craig-bampton": 'kind = "craig-bampton"\ncount = 0\nspin_stiffening = true',
    "eigenmodes": 'kind = "eigenmodes"\ncount = 6',
}
LENGTHS = (2.0, 0.5, 0.4)
CUBE = box("hexahedron", (1, 1, 1), LENGTHS)


def unclamped(path: Path) -> Path:
    """The same body without its clamp, whose nodes follow the hub."""
    text = path.read_text()
    path.write_text(
        text[: text.index("[clamp]")] + text[text.index("[interface_points.hub]") :].replace("]\n[i", ']\ntie = "rigid"\n[i')
    )
    return path


@pytest.mark.parametrize("basis", BASES)
def test_one_element_between_a_clamp_and_a_rigid_tip_has_six_shapes(basis, tmp_path):
    """Its compliance is the inverse of the element's own stiffness, seen by the motions of the tip."""
    save(build(write_body(tmp_path, CUBE, BASES[basis], tie="rigid")), tmp_path / "body.h5")
    model = load(tmp_path / "body.h5")
    assert model.n_f == 6
    np.testing.assert_allclose(model.invariants.mass, DENSITY * np.prod(LENGTHS), rtol=1e-13)  # round-off, here and below
    right = CUBE.groups["right"]
    arms = CUBE.nodes[right] - [LENGTHS[0], 0, 0]
    turned = np.stack([np.cross(np.eye(3)[axis], arms) for axis in range(3)], axis=2)
    carried = np.concatenate([np.tile(np.eye(3), (len(right), 1, 1)), turned], axis=2).reshape(-1, 6)
    matrices, (by_lambda, by_mu) = solid_matrices(element_blocks(CUBE), len(CUBE.nodes), 3), lame_factors(0.3, "space")
    at = (3 * right[:, None] + np.arange(3)).ravel()
    stiffness = MODULUS * (by_lambda * matrices.first + by_mu * matrices.shear).toarray()[np.ix_(at, at)]
    np.testing.assert_allclose(compliance(model) @ (carried.T @ stiffness @ carried), np.eye(6), atol=1e-10)
    along = (by_lambda + 2 * by_mu) * MODULUS * LENGTHS[1] * LENGTHS[2] / LENGTHS[0]  # nothing contracts across
    np.testing.assert_allclose(compliance(model)[0, 0] * along, 1.0, rtol=1e-12)


def test_all_bases_have_the_same_frequencies(tmp_path):
    found = [frequencies(build(write_body(tmp_path, CUBE, basis, tie="rigid"))) for basis in BASES.values()]
    for each in found[1:]:
        np.testing.assert_allclose(each, found[0], rtol=1e-10)  # round-off times the condition


@pytest.mark.parametrize(
    "basis", ['kind = "static"\nchord = ["hub", "tip"]', 'kind = "eigenmodes"\ncount = 6\nboundary = "free"']
)
def test_two_rigid_ties_without_a_clamp_have_six_shapes(basis, tmp_path):
    """And the same stretch: one over k of the free body is that of the clamped one, the half of it at each end."""
    model = build(unclamped(write_body(tmp_path, CUBE, basis, tie="rigid")))
    assert model.n_f == 6
    rows = (moves(model.interfaces["tip"]) - moves(model.interfaces["hub"]))[0]
    along = np.add(*np.multiply(lame_factors(0.3, "space"), (1, 2))) * MODULUS * LENGTHS[1] * LENGTHS[2] / LENGTHS[0]
    np.testing.assert_allclose(rows @ np.linalg.solve(model.invariants.stiffness, rows) * along, 1.0, rtol=1e-10)


def test_a_plane_element_has_three_shapes(tmp_path):
    model = build(write_body(tmp_path, rectangle("quad", (1, 1), 1.0, 0.4), 'kind = "static"', 0.3, "rigid"))
    assert model.n_f == 3
    along = MODULUS / (1 - 0.3**2) * WIDTH * 0.4  # plane stress that nothing lets contract across
    np.testing.assert_allclose(compliance(model)[0, 0] * along, 1.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text.replace('"full"', '"craig-bampton"\ncount = 2'), "2 modes cannot be taken: .* Choose 0"),
        (lambda text: text.replace('"full"', '"craig-bampton"\nfrequency = 100.0'), "the boundary leaves no motion"),
        (
            lambda text: text.replace('"full"', '"static"').replace(
                'tie = "rigid"', 'tie = "rigid"\n[interface_points.again]\nnodes = RIGHT'
            ),
            "cannot move independently of each other and of what is held",
        ),
        (lambda text: text.replace("[clamp]\nnodes = LEFT", "[clamp]\nbox = [-9, -9, -9, 9, 9, 9]"), "the clamp holds all nodes"),
    ],
)
def test_what_cannot_move_is_refused_in_words(change, message, tmp_path):
    path = write_body(tmp_path, CUBE, tie="rigid")
    left, right = (str(CUBE.groups[name].tolist()) for name in ("left", "right"))
    path.write_text(
        change(path.read_text().replace(left, "LEFT").replace(right, "RIGHT")).replace("LEFT", left).replace("RIGHT", right)
    )
    with pytest.raises(InputError, match=message):
        build(path)


def test_one_rigid_tie_of_all_nodes_leaves_nothing_to_deform(tmp_path):
    path = write_body(tmp_path, CUBE, 'kind = "eigenmodes"\ncount = 4\nboundary = "free"', tie="rigid")
    text = path.read_text()
    start, end = text.index("[clamp]"), text.index("[interface_points.tip]")
    path.write_text(
        (text[:start] + text[end:]).replace(f"nodes = {CUBE.groups['right'].tolist()}", "box = [-9, -9, -9, 9, 9, 9]")
    )
    with pytest.raises(InputError, match=r"the rigid tie of interface point 'tip' holds all nodes"):
        build(path)
