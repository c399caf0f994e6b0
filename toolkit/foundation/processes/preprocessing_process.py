"""Programs of the preprocessing, run in a process of their own: the runtime never imports it, as `git` never imports its commands."""

from __future__ import annotations

import subprocess

from toolkit.foundation.errors import InputError
from toolkit.foundation.processes.own_process import HOME, environment, program


def is_installed() -> bool:
    """Whether there is a preprocessing of the same version to run."""
    return (HOME / "preprocessing" / "__init__.py").is_file()


def run(name: str, arguments: list[str], content: str | None = None) -> subprocess.CompletedProcess[str]:
    """Run a module of the preprocessing of the same version, with `content` as its input, and keep what it prints.

    Raises
    ------
    InputError
        The preprocessing is not installed, or another package has its name.
    """
    if not is_installed():
        raise InputError("this needs the preprocessing. Install it: pip install 'ffrf-toolkit[preprocessing]'.")
    command = program(name, *arguments)
    return subprocess.run(command, env=environment(), input=content, capture_output=True, text=True, check=False)
