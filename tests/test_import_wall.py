"""Who may import whom: the runtime never sees preprocessing or meshing, and inside the runtime arrows run one way."""

from __future__ import annotations

import ast
import subprocess
import sys
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
        "hdf5",
        "hdf5_reader",
        "toml_file",
        "outside_files",
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
        "compile_watch",
        "planar",
        "units",
        "dimensions",
        "design",
        "replaced_file",
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
    ("solution", "flexible_bodies", "validity", "solvers", "conformance"),
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


def imports(path: Path) -> set[str]:
    """Everything that a file imports, at its top or inside of functions."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} uses a relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {str(node.module)}
    return found


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


@pytest.mark.parametrize("name", TOOLKIT)
def test_the_runtime_never_imports_preprocessing(name):
    wrong = [found for found in imports(TOOLKIT[name]) if belongs(found, FORBIDDEN)]
    if not belongs(name, DRAWING):
        wrong += [found for found in imports(TOOLKIT[name]) if belongs(found, PICTURES)]
    assert not wrong


@pytest.mark.parametrize("name", PREPROCESSING)
def test_preprocessing_imports_only_the_reduced_model_of_the_runtime(name):
    assert not [found for found in imports(PREPROCESSING[name]) if belongs(found, ("toolkit",)) and not belongs(found, SHARED)]


@pytest.mark.parametrize("name", [name for name in TOOLKIT if "." in name])
def test_arrows_inside_the_runtime_run_one_way(name):
    known = (*TOOLKIT, "toolkit")
    for found in sorted(imports(TOOLKIT[name])):
        target = found if found in known else found.rpartition(".")[0]
        if target in TOOLKIT and "." in target:
            assert layer(target) <= layer(name), f"{name} imports {target} from a later layer"


def test_only_the_runtime_modules_named_here_are_shared_with_preprocessing():
    for name in SHARED:
        needed = {found for found in imports(TOOLKIT[name]) if belongs(found, ("toolkit",))}
        assert all(belongs(found, SHARED) for found in needed), f"{name} pulls {needed} into preprocessing"
