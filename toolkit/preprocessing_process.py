"""Programs of the preprocessing, run in a process of their own: the runtime never imports it, as `git` never imports its commands."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import toolkit
from toolkit.errors import InputError


def is_installed() -> bool:
    """Whether there is a preprocessing to run."""
    return find_spec("preprocessing") is not None


def run(program: str, arguments: list[str], content: str | None = None) -> subprocess.CompletedProcess[str]:
    """Run a module of the preprocessing of the same version, with `content` as its input, and keep what it prints.

    Raises
    ------
    InputError
        The preprocessing is not installed.
    """
    if not is_installed():
        raise InputError("this needs the preprocessing. Install it: pip install '.[preprocessing]' in the project's folder.")
    here = str(Path(toolkit.__file__ or "").parents[1])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))}
    command = [sys.executable, "-m", program, *arguments]
    return subprocess.run(command, env=environment, input=content, capture_output=True, text=True, check=False)
