"""Who may import whom: the runtime never sees preprocessing or meshing, and arrows between rooms run one way, at every level."""

from __future__ import annotations

import re
import subprocess
import sys
from graphlib import CycleError

import pytest

from docs.generators.house import HALVES, ROOT, about, arrows, files, imports, modules, ordered, rooms

FORBIDDEN = ("preprocessing", "gmsh", "meshio", "skfem")
DRAWING = ("toolkit.render", "toolkit.report")
PICTURES = ("pyvista", "vtk", "vtkmodules", "matplotlib")
SHARED = ("toolkit.foundation", "toolkit.reduced_model")
"""Rooms of the runtime that preprocessing uses too."""

TOOLKIT, PREPROCESSING = files("toolkit"), files("preprocessing")


def belongs(name: str, packages: tuple[str, ...]) -> bool:
    return any(name == package or name.startswith(package + ".") for package in packages)


def test_importing_the_runtime_loads_no_preprocessing_and_no_pictures():
    names = [name for name in TOOLKIT if not belongs(name, DRAWING)]
    code = "import importlib, sys\n" + "".join(f"importlib.import_module({name!r})\n" for name in names)
    code += "print(*sorted({name.split('.')[0] for name in sys.modules}))"
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = set(run.stdout.split())
    assert "toolkit" in loaded
    assert not loaded & {*FORBIDDEN, *PICTURES}


def test_the_runtime_never_imports_preprocessing_nor_pictures():
    for name, path in TOOLKIT.items():
        forbidden = FORBIDDEN if belongs(name, DRAWING) else (*FORBIDDEN, *PICTURES)
        assert [found for found in imports(path, typing=False) if belongs(found, forbidden)] == [], name


def test_preprocessing_imports_only_the_shared_rooms_of_the_runtime():
    for name, path in PREPROCESSING.items():
        assert [found for found in imports(path) if belongs(found, ("toolkit",)) and not belongs(found, SHARED)] == [], name


def test_the_shared_rooms_of_the_runtime_need_no_others():
    for name, path in TOOLKIT.items():
        if belongs(name, SHARED):
            assert [found for found in imports(path) if belongs(found, ("toolkit",)) and not belongs(found, SHARED)] == [], name


def test_arrows_between_the_rooms_and_files_of_every_folder_run_one_way():
    for room in [room for half in HALVES for room in rooms(half)]:
        try:
            order = ordered(arrows(room))
        except CycleError as error:
            pytest.fail(f"{room}: " + " imports ".join(reversed(error.args[1])))
        assert sorted(order) == sorted(arrows(room))


COMPONENTS = ("toolkit.components.bodies", "toolkit.components.joints", "toolkit.components.loads")


def spaces(name: str) -> set[str]:
    """Of the plane and space, the one that the name of a module of components names: what is there for it alone."""
    return {"planar", "spatial"} & set(re.split("[._]", name)) if belongs(name, COMPONENTS) else set()


def test_components_of_the_plane_and_of_space_do_not_know_each_other_and_what_they_share_knows_neither():
    for name, path in TOOLKIT.items():
        if belongs(name, COMPONENTS):
            others = {"planar", "spatial"} - spaces(name) if "kernels" not in name.split(".") or spaces(name) else set()
            assert [found for found in imports(path) if spaces(found) & others] == [], name


def test_nobody_asks_which_dimension_a_scene_has_but_the_one_record_and_what_reads_models():
    asked = re.compile(r"dimension\s*[!=]=\s*[0-9]")
    others = {name: path for name, path in TOOLKIT.items() if not belongs(name, ("toolkit.reduced_model",))}
    assert [name for name, path in others.items() if asked.search(path.read_text(encoding="utf-8"))] == []


def test_every_module_stands_in_a_room_that_says_what_it_is_for():
    for half in HALVES:
        assert [name for name in modules(half) if name.count(".") < 2] == []
        for room in rooms(half):
            assert about(room).endswith("."), room


SMALL = 80
"""Lines below which a module that one neighbour alone imports belongs into that neighbour."""
ONE_EACH = (
    "toolkit.components.joints.",
    "toolkit.components.loads.",
    "toolkit.components.curves.",
    "toolkit.responses.",
    "toolkit.command_line.commands.",
    "preprocessing.elements.wedge",
)
"""Rooms of kinds that users name: each kind has a file of its own, however small."""
APART = {
    "toolkit.command_line.completion",
    "preprocessing.projects.arm",
}
"""Small modules whose neighbour is long already, or uses the same names for other things."""


def test_a_small_module_that_one_neighbour_alone_imports_stands_in_that_neighbour():
    known = {**TOOLKIT, **PREPROCESSING}
    users = {name: {other for other, path in known.items() if other != name and name in imports(path)} for name in known}
    found = {
        name
        for name, path in known.items()
        if path.name != "__init__.py" and len(users[name]) == 1 and len(path.read_text(encoding="utf-8").splitlines()) < SMALL
        if next(iter(users[name])).rpartition(".")[0] == name.rpartition(".")[0] and not name.startswith(ONE_EACH)
    }
    assert found <= APART
