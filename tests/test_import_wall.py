"""Who may import whom: the runtime never sees preprocessing or meshing, and inside the runtime arrows run one way."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FORBIDDEN = ("preprocessing", "gmsh", "meshio", "skfem")
DRAWING = ("toolkit.render", "toolkit.report")
PICTURES = ("pyvista", "vtk", "vtkmodules", "matplotlib")
SHARED = tuple(
    f"toolkit.{name}"
    for name in (
        "dependence",
        "entry_scales",
        "mode_shapes",
        "reduced_model",
        "reduced_model_check",
        "reduced_model_file",
        "spatial_model",
        "replaced_file",
        "regular_file",
        "hdf5",
        "hdf5_reader",
        "toml_file",
        "outside_files",
        "own_process",
        "regular_file",
        "errors",
        "units",
        "validity.material_questions",
        "validity.verdict",
    )
)

LAYERS = [
    (
        "errors",
        "kernel",
        "compiled_code",
        "formula_stamp",
        "compile_watch",
        "planar",
        "units",
        "dimensions",
        "design",
        "replaced_file",
        "regular_file",
        "hdf5",
        "hdf5_reader",
        "toml_file",
        "outside_files",
        "own_process",
        "preprocessing_process",
        "listed_names",
        "mode_shapes",
        "near_ties",
        "static_path",
        "spatial",
    ),
    ("description", "validation_messages", "run_options", "option_checks", "time_grid", "profile"),
    ("dependence", "spatial_model"),
    (
        "reduced_model",
        "entry_scales",
        "reduced_model_check",
        "reduced_model_file",
        "reduced_model_units",
        "design_point",
        "linear",
    ),
    ("point", "component", "about_axis", "bodies"),
    ("loads", "joints"),
    ("scene", "scene_names", "scene_kinds", "vector_paths", "equations"),
    ("compilation",),
    ("system", "redundant_joints"),
    ("solution", "marker_states", "flexible_bodies", "validity", "solvers", "conformance"),
    ("responses",),
    ("sensitivity", "scene_file", "scene_schema", "scene_dimensions", "scene_units", "gradient_units"),
    ("results",),
    ("studies", "receipt"),
    ("render",),
    ("report",),
    ("cli", "command_line"),
]
"""Modules of the toolkit in the order of the arrows: each may import from its own layer and the layers before it."""


def modules(package: str) -> dict[str, Path]:
    """Dotted name to file of every module of a package."""
    found = {}
    for path in sorted((ROOT / package).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path, typing: bool = True) -> set[str]:
    """Everything that a file imports, at its top or inside of functions; without `typing` not what its annotations alone need."""
    found: set[str] = set()
    left_out = set() if typing else {node for block in _for_annotations(tree(path)) for node in ast.walk(block)}
    for node in ast.walk(tree(path)):
        if node in left_out:
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} uses a relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {str(node.module)}
    return found


def _for_annotations(module: ast.Module) -> list[ast.If]:
    return [node for node in module.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]


def belongs(name: str, packages: tuple[str, ...]) -> bool:
    return any(name == package or name.startswith(package + ".") for package in packages)


def layer(module: str) -> int:
    part = module.split(".")[1]
    found = [k for k, names in enumerate(LAYERS) if part in names]
    assert found, f"{module} is in no layer: add toolkit/{part} to LAYERS in {Path(__file__).name}"
    return found[0]


TOOLKIT, PREPROCESSING = modules("toolkit"), modules("preprocessing")


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
        assert [found for found in imports(path) if belongs(found, forbidden)] == [], name


def test_preprocessing_imports_only_the_reduced_model_of_the_runtime():
    for name, path in PREPROCESSING.items():
        assert [found for found in imports(path) if belongs(found, ("toolkit",)) and not belongs(found, SHARED)] == [], name


def test_arrows_inside_the_runtime_run_one_way():
    known = (*TOOLKIT, "toolkit")
    for name in [name for name in TOOLKIT if "." in name]:
        for found in sorted(imports(TOOLKIT[name])):
            target = found if found in known else found.rpartition(".")[0]
            if target in TOOLKIT and "." in target:
                assert layer(target) <= layer(name), f"{name} imports {target} from a later layer"


def test_no_files_import_each_other_in_a_circle():
    files = TOOLKIT | PREPROCESSING
    arrows = {name: imports(path, typing=False) & files.keys() - {name} for name, path in files.items()}
    try:
        order = list(TopologicalSorter(arrows).static_order())
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))
    assert len(order) == len(files)


def test_only_the_runtime_modules_named_here_are_shared_with_preprocessing():
    for name in SHARED:
        needed = {found for found in imports(TOOLKIT[name]) if belongs(found, ("toolkit",))}
        assert all(belongs(found, SHARED) for found in needed), f"{name} pulls {needed} into preprocessing"
