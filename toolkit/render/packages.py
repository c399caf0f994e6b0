"""What pictures need of this machine."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.processes import command
from toolkit.foundation.processes import environment as own_environment


class RenderError(ToolkitError, RuntimeError):
    """Pictures cannot be drawn on this machine; the message says what to install."""


_EXTRA = {"imageio_ffmpeg": "film"}
"""Packages that do not come with the extra `render`."""


def require(*modules: str) -> None:
    """Refuse to go on without a package that pictures need."""
    for module in modules:
        if find_spec(module) is None:
            name, extra = module.replace("_", "-"), _EXTRA.get(module, "render")
            raise RenderError(f"pictures need {name}, which is not installed. Install: pip install 'ffrf-toolkit[{extra}]'.")


VARIABLE = "VTK_DEFAULT_OPENGL_WINDOW"
LIBRARIES = {"vtkEGLRenderWindow": "libEGL.so.1", "vtkOSOpenGLRenderWindow": "libOSMesa.so.8"}
"""Kinds of windows that need no screen, and the library that each lives on."""
PACKAGES = "libegl1 libgl1-mesa-dri"
_TRIAL = """
import ctypes, sys
for library in sys.argv[1:]:
    ctypes.CDLL(library)
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 32))
plotter.add_mesh(pyvista.Sphere(), color="red")
image = plotter.screenshot(return_img=True)
plotter.close()
sys.exit(None if image.min() < image.max() else "the picture is empty")
"""
_PATIENCE = 120  # s; a first import of a cold installation takes several seconds
_DRAWN: dict[tuple[str | None, str | None], dict[str, str]] = {}
"""The screen and window that are asked for -> the environment under which a trial picture was drawn: what has worked is not tried again."""


def drawing_environment() -> dict[str, str]:
    """Environment variables under which a picture can be drawn here, found by drawing one in a subprocess, the first time.

    Raises
    ------
    RenderError
        pyvista is not installed, or no OpenGL library works; names the packages that bring them.
    """
    require("pyvista")
    asked = os.environ.get("DISPLAY"), os.environ.get(VARIABLE)
    if asked in _DRAWN:
        return _DRAWN[asked]
    failures = []
    for environment in _candidates():
        problem = _trial(environment)
        if problem is None:
            return _DRAWN.setdefault(asked, environment)
        failures.append(problem)
    raise RenderError(
        f"pictures of space need OpenGL, and a trial picture failed ({'; '.join(failures)}). "
        f"On Debian and Ubuntu install it with: apt-get install {PACKAGES}. Everything else works without it."
    )


def _candidates() -> list[dict[str, str]]:
    """Environments to try: the screen if there is one or a window was chosen; on Linux also windows that need no screen."""
    if not sys.platform.startswith("linux") or VARIABLE in os.environ:
        return [{}]
    hidden = [{VARIABLE: window} for window in LIBRARIES]
    return [{}, *hidden] if os.environ.get("DISPLAY") else hidden


def _trial(environment: Mapping[str, str]) -> str | None:
    """Draw a tiny picture in a subprocess: None if that worked, otherwise what went wrong."""
    libraries = [LIBRARIES[window] for window in environment.values()]
    try:
        done = subprocess.run(
            command(_TRIAL, *libraries),
            env={**own_environment(), **environment}, capture_output=True, text=True, timeout=_PATIENCE, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"no picture after {_PATIENCE} s"
    if done.returncode == 0:
        return None
    if done.returncode < 0:
        return f"{' '.join(libraries) or 'the screen'}: the process crashed with signal {-done.returncode}"
    return (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]


@contextmanager
def drawing() -> Iterator[None]:
    """Context in which space can be drawn: the working environment, for this process and this long only."""
    environment = drawing_environment()
    os.environ.update(environment)
    try:
        yield
    finally:
        for name in environment:
            del os.environ[name]
