"""Files that cannot be written to their end: one message, the old file as it was, and nothing left behind.

A disk that is full cannot be had without the rights of an administrator, a limit on the size of files can: writing fails in the same
places, with another word from the system.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from toolkit.description.results_layout import ResultsFileError
from toolkit.files.results_file import refuse_foreign
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import OWN, replaced, write_whole

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
WITHIN_LIMITS = """
import contextlib, io, json, resource, sys
from pathlib import Path
import preprocessing.commands.cli, toolkit.command_line.cli
from toolkit.render.sheet import sheet
from toolkit.report.drawing import Drawing
from toolkit.foundation.errors import ToolkitError

def run(program, *arguments):
    sys.argv, said = [program, *arguments], io.StringIO()
    main = preprocessing.commands.cli.main if program == "ffrf-preprocess" else toolkit.command_line.cli.main if program == "ffrf" else draw
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        try:
            main()
        except SystemExit as end:
            return end.code or 0, said.getvalue()

def draw():
    with sheet(2.0) as (figure, _):
        pass
    try:
        Drawing("picture", "", "", figure).save(Path(sys.argv[1]))
    except ToolkitError as error:
        sys.stderr.write(str(error))
        sys.exit(1)

first, *commands = json.loads(sys.argv[1])
assert run(*first) == (0, ""), first
sys.dont_write_bytecode = True  # Python would leave 100 bytes of it for all who come after
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
print(json.dumps([run(*command) for command in commands]))
"""
OLD = b"what was there before"


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    """Commands in one process in which no file grows beyond 100 bytes: their exit codes and messages, and the folder they wrote to."""
    folder = tmp_path_factory.mktemp("full")
    scene, skin, kept = (str(path) for path in (WING / "scene.toml", WING / "skin.toml", folder / "kept.h5"))
    for name in ("model", "results", "pictures", "tables", "series", "solid"):
        (folder / name).mkdir()
    (folder / "model" / "skin.h5").write_bytes((WING / "skin.h5").read_bytes())
    (folder / "pictures" / "picture.png").write_bytes(OLD)
    commands = {
        "kept": ("ffrf", "statics", scene, "--output", kept, "--quiet"),
        "model": ("ffrf-preprocess", skin, "--force", "--overwrite", "--output", str(folder / "model" / "skin.h5")),
        "results": ("ffrf", "statics", scene, "--output", str(folder / "results" / "run.h5"), "--quiet"),
        "pictures": ("draw", str(folder / "pictures")),
        "tables": ("ffrf", "export", kept, "--csv", str(folder / "tables")),
        "series": ("ffrf", "export", kept, "--paraview", str(folder / "series")),
        "solid": ("ffrf-preprocess", skin, "--extrude", str(folder / "solid" / "skin.msh")),
        "wing": ("ffrf", "new", "wing", str(folder / "wing"), "--airfoil", str(WING / "high_speed.dat")),
    }
    command = [sys.executable, "-P", "-c", WITHIN_LIMITS, json.dumps(list(commands.values()))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return folder, dict(zip(list(commands)[1:], json.loads(done.stdout), strict=True))


@pytest.mark.parametrize("kind", ["model", "results", "pictures", "tables", "series", "solid", "wing"])
def test_a_command_that_cannot_write_to_the_end_says_so_and_leaves_no_part_of_a_file(outcome, kind):
    folder, found = outcome
    code, said = found[kind]
    assert code == 1
    assert "cannot be written (File too large). Give a writable place." in said
    assert "Traceback" not in said
    left = {path.name: path.read_bytes() for path in (folder / kind).iterdir() if path.name != OWN}  # names alone, listed before
    before = {"model": {"skin.h5": (WING / "skin.h5").read_bytes()}, "pictures": {"picture.png": OLD}}
    assert left == before.get(kind, {})


def test_the_output_of_a_command_that_nobody_can_take_is_one_message():
    command = [sys.executable, "-P", "-c", "from toolkit.command_line.cli import main; main()", "inspect", str(WING / "skin.h5")]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "the system refused to go on: No space left on device. Fix the path, or make room on the disk.\n"


def test_a_file_is_on_the_disk_before_it_takes_its_name(tmp_path, monkeypatch):
    (tmp_path / "file.h5").write_bytes(OLD)
    seen = []
    monkeypatch.setattr(os, "fsync", lambda handle: seen.append((os.fstat(handle).st_size, (tmp_path / "file.h5").read_bytes())))
    write_whole(tmp_path / "file.h5", b"new")
    assert seen == [(3, OLD)]
    assert (tmp_path / "file.h5").read_bytes() == b"new"


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o660])
def test_links_and_permissions_of_what_is_replaced_stay(tmp_path, mode):
    (tmp_path / "elsewhere").mkdir()
    target, link = tmp_path / "elsewhere" / "run.h5", tmp_path / "run.h5"
    target.write_bytes(OLD)
    target.chmod(mode)
    link.symlink_to(Path("elsewhere") / "run.h5")
    write_whole(link, b"new")
    assert link.is_symlink()
    assert (target.read_bytes(), target.stat().st_mode & 0o777) == (b"new", mode)
    assert [path.name for path in target.parent.iterdir()] == ["run.h5"]


def test_a_new_file_has_the_permissions_that_the_user_gives_to_all(tmp_path):
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "run.h5", b"new")
    finally:
        os.umask(before)
    assert (tmp_path / "run.h5").stat().st_mode & 0o777 == 0o640


def test_a_pipe_is_no_place_for_results_and_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "run.h5")
    with pytest.raises(ResultsFileError, match=r"run\.h5' exists and is not a results file; it is left as it is"):
        refuse_foreign(tmp_path / "run.h5")


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["pipe", "folder"])
def test_what_is_no_file_is_not_replaced(tmp_path, make):
    make(tmp_path / "run.h5")
    kind = (tmp_path / "run.h5").lstat().st_mode
    with pytest.raises(InputError, match=r"cannot be written \(it is not a regular file\)"), replaced(tmp_path / "run.h5"):
        pass
    assert (tmp_path / "run.h5").lstat().st_mode == kind
    assert len(list(tmp_path.iterdir())) == 1
