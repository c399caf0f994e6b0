"""Running hostile cases, each in a process with bounded memory and time: forked from one that has loaded the program, or fresh."""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from io import BytesIO
from pathlib import Path
from typing import Any

from preprocessing.foreign_files import apart
from preprocessing.foreign_files.child import Bounds
from preprocessing.mesh import mesh_file
from tests.fuzz.case import Case, Ended
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.processes import command, environment

MEMORY = 3 * 2**30
"""Bytes of address space of a command, besides what the program takes itself."""
SECONDS, READER_SECONDS = 60, 2
"""Time of a command on the clock, and processor time of a reader in it."""
MODELS = Path(__file__).parents[2] / "models"
PROGRAMS = {"ffrf": "toolkit.command_line.cli", "ffrf-preprocess": "preprocessing.commands.cli"}
LOADED = (
    "preprocessing.commands.cli",
    *(
        "preprocessing.builders.reduced_body",
        "preprocessing.foreign_files.mesh_reader",
        "preprocessing.foreign_files.matrix_entries",
        "preprocessing.foreign_files.nastran.bulk_file",
    ),
    *("preprocessing.foreign_files.child", "scipy.io"),
)
"""What is loaded before the first case."""
SCENES = ("toolkit.command_line.cli", "toolkit.api.model", "toolkit.files.scene_reader", "toolkit.system")
"""What is loaded before cases that have scenes."""


def load(names: tuple[str, ...]) -> None:
    """Load the program, so that cases need not; its objects are not looked through for garbage, which would copy them."""
    for name in names:
        importlib.import_module(name)
    _build_once() if names == LOADED else _solve_once()
    gc.disable()
    gc.freeze()


def _build_once() -> None:
    """Build a good body, which loads what is loaded late."""
    from preprocessing import build
    from preprocessing.foreign_files import child
    from toolkit.reduced_model.file import save

    for model in ("bracket", "spatial_bracket"):
        found = child.reading("mesh", str(MODELS / model / "bracket.msh"))["found"]
        apart.read_apart, original = (lambda *_, found=found, **__: found), apart.read_apart
        mesh_file.read_apart = apart.read_apart
        with tempfile.TemporaryDirectory() as folder:
            save(build(MODELS / model / "body.toml"), Path(folder) / "body.h5")
        apart.read_apart = mesh_file.read_apart = original


def _solve_once() -> None:
    """Find the equilibrium of all scenes, which loads the compiled formulas."""
    from toolkit.analyses.sensitivity.direct import direct
    from toolkit.files.scene_reader import read_scene

    for scene in sorted(MODELS.glob("*/scene.toml")):
        described = read_scene(scene)
        with contextlib.suppress(ToolkitError):
            direct(described, list(described.design), "static")


def run_forked(case: Case, folder: Path, seconds: float = SECONDS) -> Ended:
    """The command in a copy of this process; its readers of foreign files in copies of that one."""
    output = folder.with_name("said")
    child = os.fork()
    if child == 0:
        code = 70
        try:
            code = _in_copy(case, folder, output)
        finally:
            os._exit(code)
    ended = waited(child, seconds)
    return Ended(ended, output.read_text(errors="replace"))


def _in_copy(case: Case, folder: Path, output: Path) -> int:
    os.setsid()
    handle = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for channel in (1, 2):
        os.dup2(handle, channel)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    bounded(own_memory() + MEMORY)
    os.chdir(folder)
    apart.run = reader_in_copy
    sys.argv = list(case.arguments)
    try:
        importlib.import_module(PROGRAMS[case.arguments[0]]).main()
        code: Any = 0
    except SystemExit as end:
        code = end.code or 0
    except BaseException:  # noqa: BLE001 (this is what is looked for)
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    return code if isinstance(code, int) else 1


def reader_in_copy(reader: str, path: Path, bounds: Bounds, *more: str) -> apart.ReaderEnded:
    """What `apart.run` does, without loading the libraries again."""
    from preprocessing.foreign_files.child import reading
    from preprocessing.foreign_files.wire import send

    here, there = os.pipe()
    child = os.fork()
    if child == 0:
        code = 70
        try:
            os.close(here)
            Bounds(own_memory() + bounds.memory, min(bounds.seconds, READER_SECONDS)).impose()
            found = reading(reader, str(path), *more)
            with os.fdopen(there, "wb") as stream:
                try:
                    send(stream, found)
                except (TypeError, ValueError) as error:
                    send(stream, {"reason": str(error)})
            code = 0
        finally:
            os._exit(code)
    os.close(there)
    signal.signal(signal.SIGALRM, lambda *_: os.kill(child, signal.SIGALRM))
    signal.alarm(10 * READER_SECONDS)  # on a busy machine
    with os.fdopen(here, "rb") as stream:
        content = stream.read()
    _, status = os.waitpid(child, 0)
    signal.alarm(0)
    code = os.waitstatus_to_exitcode(status)
    return apart.ReaderEnded(None if code == -signal.SIGALRM else code, BytesIO(content))


def run_fresh(case: Case, folder: Path, seconds: float = SECONDS) -> Ended:
    """The command as pip installs it."""
    code = f"import sys\nsys.argv = {list(case.arguments)!r}\nfrom {PROGRAMS[case.arguments[0]]} import main\nmain()"
    started = subprocess.Popen(
        command(code),
        env=environment(),
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        preexec_fn=lambda: bounded(MEMORY + 2**30),
        start_new_session=True,
    )
    try:
        said, _ = started.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(started.pid, signal.SIGKILL)
        started.communicate()
        return Ended(None, "")
    return Ended(started.returncode, said.decode(errors="replace"))


def bounded(memory: int) -> None:
    """Put this process under limits."""
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**28, 2**28))


def own_memory() -> int:
    """Bytes of address space that this process takes."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")


def waited(child: int, seconds: float) -> int | None:
    """Exit code of a process; None if it had to be ended, with all that it started."""
    end = time.monotonic() + seconds
    pause = 0.001
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(pause)
        pause = min(1.5 * pause, 0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None
