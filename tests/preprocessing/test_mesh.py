"""The mesh: stations pass through gmsh unchanged, in order, and gmsh's global state is left as it was."""

import signal
import sys
from concurrent.futures import ThreadPoolExecutor

import gmsh
import numpy as np
import pytest

from preprocessing.builders.curve_mesh import load_gmsh, mesh_curve, walk
from toolkit.foundation.errors import InputError


def arc(n_nodes: int, radius: float = 2.0) -> np.ndarray:
    angle = np.linspace(0.3, 2.5, n_nodes)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("n_nodes", [2, 3, 31])
def test_nodes_are_the_stations_and_elements_join_neighbours(n_nodes):
    stations = arc(n_nodes)
    mesh = mesh_curve(stations)
    assert np.array_equal(mesh.nodes, stations)  # gmsh stores doubles and computes nothing
    assert mesh.connectivity.tolist() == [[i, i + 1] for i in range(n_nodes - 1)]


def test_element_coordinates_are_those_of_its_two_nodes():
    mesh = mesh_curve(arc(4))
    assert mesh.dofs[1].tolist() == [3, 4, 5, 6, 7, 8]
    assert np.array_equal(mesh.ends[1], mesh.nodes[[1, 2]])


def test_walk_orders_a_chain_whose_elements_are_shuffled_and_turned():
    chain = np.array([[7, 3], [3, 9], [9, 1], [1, 4]])
    shuffled = chain[[2, 0, 3, 1]]
    shuffled[1] = shuffled[1, ::-1]
    assert walk(shuffled, 7) == [7, 3, 9, 1, 4]
    assert walk(shuffled, 4) == [4, 1, 9, 3, 7]


def test_session_is_closed_and_the_interrupt_handler_kept():
    handler = signal.getsignal(signal.SIGINT)
    mesh_curve(arc(5))
    assert not gmsh.isInitialized()
    assert signal.getsignal(signal.SIGINT) is handler


def test_session_of_the_caller_survives_with_its_model():
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("mine")
        mesh_curve(arc(5))
        assert gmsh.model.getCurrent() == "mine"
        assert "skin" not in gmsh.model.list()
    finally:
        gmsh.finalize()


def test_meshes_made_in_several_threads_do_not_mix():
    sizes = [5, 9, 14, 23] * 3
    with ThreadPoolExecutor(4) as pool:
        meshes = list(pool.map(mesh_curve, [arc(n, radius=n) for n in sizes]))
    for n, mesh in zip(sizes, meshes, strict=True):
        assert np.array_equal(mesh.nodes, arc(n, radius=n))


@pytest.mark.parametrize(
    ("stations", "message"),
    [
        (np.array([[0.0, 0.0]]), "at least two stations"),
        (np.array([[0.0, 0.0], [np.nan, 1.0], [2.0, 0.0]]), "station 1 of the skin is not finite"),
        (np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 1.0]]), "stations 1 and 2 of the skin coincide; use fewer elements"),
    ],
)
def test_stations_that_no_element_can_join_are_refused(stations, message):
    with pytest.raises(InputError, match=message):
        mesh_curve(stations)


def test_a_missing_gmsh_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(InputError, match=r"pip install 'ffrf-toolkit\[preprocessing\]'.*libglu1-mesa"):
        load_gmsh()
