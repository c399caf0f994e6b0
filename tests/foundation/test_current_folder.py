"""Nothing that lies in the current folder is executed, whatever its name; and a package with the name of one of ours is named."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import h5py
import pytest
from PIL import Image
from typer.testing import CliRunner

from toolkit.analyses.sensitivity.certificate.fresh_models import build_all
from toolkit.command_line.cli import app
from toolkit.foundation import processes
from toolkit.foundation.errors import InputError
from toolkit.foundation.kernel import plain
from toolkit.foundation.processes import HOME, safe_path
from toolkit.reduced_model.file import load
from toolkit.render import packages
from toolkit.render.animation import mp4
from toolkit.render.packages import RenderError, drawing_environment
from toolkit.studies.executor import Executor, completed

ROOT = Path(__file__).parents[2]
WING = ROOT / "models" / "morphing_wing"
TRAP = "from pathlib import Path\nPath({mark!r}).open('a').write(__name__ + '\\n')\n"
PACKAGES = ("preprocessing", "toolkit", "multiprocessing", "importlib", "concurrent")
MODULES = (
    *("random", "json", "ctypes", "runpy", "pickle", "tempfile", "typing", "dataclasses", "sitecustomize", "usercustomize"),
    *("numpy", "scipy", "numba", "h5py", "typer", "pyvista", "gmsh", "meshio", "skfem", "matplotlib"),
)
COMMANDS = ("new_wing_command", "designs_command", "corotational_command", "cli")


@pytest.fixture
def trap(tmp_path, monkeypatch):
    """A current folder full of modules that leave a mark when they are executed; gives the mark."""
    folder, mark = tmp_path / "downloads", tmp_path / "executed"
    files = [f"{name}/__init__.py" for name in PACKAGES] + [f"{name}.py" for name in MODULES]
    files += [f"{package}/{name}.py" for package in ("preprocessing", "toolkit") for name in COMMANDS]
    for file in files:
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(TRAP.format(mark=str(mark)))
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PYTHONPATH", os.pathsep)  # an empty entry is the current folder too, and is easily written
    return mark


def run(*arguments: str | Path) -> str:
    done = CliRunner().invoke(app, [str(each) for each in arguments])
    assert done.exit_code == 0, done.output
    return done.output


def test_the_traps_are_sprung_by_a_process_that_is_started_without_care(trap):
    subprocess.run([sys.executable, "-c", "import random"], check=False)
    assert {"sitecustomize", "random"} <= set(trap.read_text().split())


def test_a_new_wing_by_the_command_as_pip_installs_it(trap, tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONPATH")
    script = tmp_path / "bin" / "ffrf"
    script.parent.mkdir()
    script.write_text("import sys\nfrom toolkit.command_line.cli import main\nsys.exit(main())\n")
    command = [sys.executable, str(script), "new", "wing", str(tmp_path / "wing"), "--airfoil", str(WING / "high_speed.dat")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "wing" / "scene.toml").is_file()
    assert not trap.exists()


def test_a_body_that_is_solved_again_by_a_command(trap):
    run("check-deformation", WING / "scene.toml", "--static", "--quiet")
    assert not trap.exists()


def test_models_that_are_built_afresh_as_certify_and_tradeoff_do(trap, tmp_path):
    build_all(WING / "skin.toml", [{"file": str(tmp_path / "thick.h5"), "values": {"thickness": 1.6}}])
    assert load(tmp_path / "thick.h5").nominal["thickness"] == 1.6
    assert not trap.exists()


def test_a_model_of_another_program_that_the_library_rewrites(trap, tmp_path):
    with h5py.File(WING / "skin.h5") as good, h5py.File(tmp_path / "skin.h5", "w", track_order=True) as plain:
        for name in good:
            good.copy(name, plain)
        plain.attrs.update({name: value.decode() if isinstance(value, bytes) else value for name, value in good.attrs.items()})
    assert load(tmp_path / "skin.h5").plain
    assert not trap.exists()


def test_a_pool_of_processes_as_tradeoff_and_stability_start_it(trap):
    found = dict(
        completed(Executor(processes=2), plain, {1: "a", 2: "b"})
    )  # the work is in a module that loads numba and what that loads
    assert found == {1: "a", 2: "b"}
    assert not trap.exists()
    assert "PYTHONSAFEPATH" not in os.environ
    assert os.environ["PYTHONPATH"] == os.pathsep


def test_settings_of_figures_in_the_current_folder_start_no_latex(tmp_path):
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\n")
    for name in ("latex", "tex"):
        (tmp_path / name).write_text(f"#!/bin/sh\n: > '{tmp_path}/executed'\nexit 1\n")
        (tmp_path / name).chmod(0o755)
    code = (
        "from pathlib import Path; import numpy as np\n"
        "from toolkit.render.sheet import sheet\n"
        "from toolkit.report.drawing import Drawing\n"
        "with sheet(2.0) as (figure, axes):\n    axes[0, 0].set_title('a figure')\n"
        "Drawing('a', 'b', 'c', figure).save_as(Path('figure.png'))\n"
    )
    path = os.pathsep.join([str(tmp_path), os.environ["PATH"]])
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=tmp_path, env={**os.environ, "PATH": path}, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "executed").exists()


def test_a_film_is_made_by_the_packages_own_program(tmp_path, monkeypatch):
    mine = tmp_path / "ffmpeg"
    mine.write_text(f"#!/bin/sh\n: > '{tmp_path}/executed'\nexit 1\n")
    mine.chmod(0o755)
    monkeypatch.chdir(tmp_path)
    assert mp4([Image.new("RGB", (64, 48), "white")] * 2)[4:8] == b"ftyp"
    assert not (tmp_path / "executed").exists()


def test_no_other_code_starts_processes_than_what_is_tested_here():
    starts = re.compile(r"\b(subprocess|multiprocessing|ProcessPoolExecutor|Popen|os\.(system|exec|spawn|posix_spawn|fork)\w*)\b")
    files = [file for half in ("toolkit", "preprocessing") for file in (ROOT / half).rglob("*.py")]
    code = {file: re.sub(r'""".*?"""|#.*', "", file.read_text(), flags=re.DOTALL) for file in files}
    found = {file.relative_to(ROOT).as_posix() for file in files if starts.search(code[file])}
    assert found == {
        *(
            "toolkit/foundation/files/plain_hdf5.py",
            "toolkit/foundation/processes.py",
            "toolkit/render/animation.py",
            "toolkit/render/packages.py",
            "toolkit/studies/executor.py",
        ),
        "preprocessing/foreign_files/apart.py",
    }


@pytest.fixture
def namesake(tmp_path, monkeypatch):
    """A package of another program, earlier on the path."""
    (tmp_path / "preprocessing").mkdir()
    (tmp_path / "preprocessing" / "__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path / "preprocessing"


def test_a_package_with_the_name_of_one_of_ours_is_named(namesake):
    message = re.escape(f"'{namesake}' has the name of a part of this program, '{HOME / 'preprocessing'}', and comes before it")
    with pytest.raises(InputError, match=message):
        processes.run("preprocessing.projects.command", [])
    with pytest.raises(InputError, match=message):
        list(completed(Executor(processes=2), os.path.basename, {1: "a", 2: "b"}))


def test_the_preprocessing_does_not_work_with_a_namesake_of_the_runtime(tmp_path):
    (tmp_path / "toolkit").mkdir()
    (tmp_path / "toolkit" / "__init__.py").touch()
    path = os.pathsep.join(map(str, (tmp_path, HOME)))
    done = subprocess.run(
        [sys.executable, "-P", "-c", "import preprocessing.commands.cli"],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        check=False,
    )
    assert f"'toolkit' is not the other half of this program, '{HOME / 'toolkit'}', but {tmp_path}" in done.stderr.decode()


@pytest.mark.parametrize("half", ["toolkit", "preprocessing"])
def test_a_foreign_half_is_named_when_the_public_names_are_imported(half, tmp_path):
    (tmp_path / half).mkdir()
    (tmp_path / half / "__init__.py").touch()
    done = subprocess.run(
        [sys.executable, "-P", "-c", "import ffrf; ffrf.preprocessing"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (tmp_path, HOME)))},
        capture_output=True,
        check=False,
    )
    assert (
        f"ImportError: '{half}' is not the half of ffrf-toolkit, '{HOME / half}', but {tmp_path / half}" in done.stderr.decode()
    )


def test_the_path_of_processes_lacks_the_current_folder_unless_the_program_is_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", ["", ".", "relative", str(tmp_path), "/elsewhere"])
    assert safe_path() == ["/elsewhere", str(HOME)]
    monkeypatch.chdir(HOME)
    monkeypatch.setattr(sys, "path", [str(HOME), "/elsewhere"])
    assert safe_path() == [str(HOME), "/elsewhere"]


def test_the_trial_picture(trap, monkeypatch):
    monkeypatch.setattr(packages, "_DRAWN", {})
    with suppress(RenderError):  # a machine without OpenGL, which the trial has found out
        drawing_environment()
    assert not trap.exists()
