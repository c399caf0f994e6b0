"""What is shipped: a source archive that the wheel can be built from, and a wheel that works without the project's folder."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LEFT_OUT = (".git", ".venv", "__pycache__", "*.egg-info", "build", "output", "site", ".*_cache", ".hypothesis")
BUILD = "import sys; from setuptools import build_meta; print(getattr(build_meta, sys.argv[1])(sys.argv[2]))"


def built(what: str, source: Path, folder: Path) -> Path:
    """The archive that setuptools makes of a folder, as pip would have it made."""
    done = subprocess.run(
        [sys.executable, "-c", BUILD, what, str(folder)], cwd=source, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder / done.stdout.splitlines()[-1]


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    """Unpacked source archive, wheel built from it, and the wheel unpacked."""
    folder = tmp_path_factory.mktemp("shipped")
    shutil.copytree(ROOT, folder / "project", ignore=shutil.ignore_patterns(*LEFT_OUT))
    archive = built("build_sdist", folder / "project", folder)
    with tarfile.open(archive) as file:
        file.extractall(folder / "source", filter="data")
    (source,) = (folder / "source").iterdir()
    wheel = built("build_wheel", source, folder)
    with zipfile.ZipFile(wheel) as file:
        file.extractall(folder / "installed")
    return source, folder / "installed"


def files(folder: Path, *below: str) -> set[str]:
    """Files of a project's folders that are its own."""
    found = (path for name in below for path in (folder / name).rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix() for path in found if "__pycache__" not in path.parts}


def test_the_source_archive_holds_all_of_the_project(shipped):
    source, _ = shipped
    parts = ("ffrf", "toolkit", "preprocessing", "models", "schemas", "tests", "tutorials", "docs", ".ci")
    assert files(source, *parts) == files(ROOT, *parts)
    assert {"README.md", "Makefile", "mkdocs.yml", "pyproject.toml"} <= {path.name for path in source.iterdir()}


def test_the_wheel_holds_both_halves_with_what_they_read_models_and_schemas(shipped):
    _, installed = shipped
    assert files(installed, "ffrf", "toolkit", "preprocessing") == files(ROOT, "ffrf", "toolkit", "preprocessing")
    assert {
        "ffrf/py.typed",
        "toolkit/py.typed",
        "preprocessing/py.typed",
        "toolkit/foundation/codes.toml",
        "toolkit/report/page.html",
        "toolkit/report/viewer.html",
    } <= files(installed, "ffrf", "toolkit", "preprocessing")
    (data,) = installed.glob("*.data")
    share = data / "data" / "share" / "ffrf-toolkit"
    assert files(share, "models") == files(ROOT, "models")
    assert files(share, "schemas") == {name for name in files(ROOT, "schemas") if name.endswith(".json")}
    for scene in share.glob("models/*/scene.toml"):  # the schema that editors find by the first line
        assert (scene.parent / scene.read_text().splitlines()[0].removeprefix("#:schema ")).is_file()
    tops = {path.name.split("-")[0] for path in installed.iterdir()}
    assert tops == {"ffrf", "toolkit", "preprocessing", "ffrf_toolkit"}


def test_the_wheel_works_without_the_folder_of_the_project(shipped, tmp_path):
    _, installed = shipped
    (scene,) = installed.glob("*.data/data/share/ffrf-toolkit/models/morphing_wing/scene.toml")
    code = (
        "import sys, toolkit, preprocessing.commands.cli; from toolkit.command_line.cli import app; from typer.testing import CliRunner\n"
        "print(toolkit.__file__, preprocessing.__file__)\n"
        "done = CliRunner().invoke(app, ['inspect', sys.argv[1], '--no-measure']); print(done.output); sys.exit(done.exit_code)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(installed), "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-P", "-c", code, str(scene)]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == f"{installed / 'toolkit' / '__init__.py'} {installed / 'preprocessing' / '__init__.py'}"
    assert "bodies.skin.thickness: 1.5" in done.stdout
