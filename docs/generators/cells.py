"""Scripts with `# %%` cells, run cell by cell: what each prints and draws."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
_RUNNER = """
import io, json, sys
from contextlib import redirect_stdout
from pathlib import Path

file, folder, cells = sys.argv[1], Path(sys.argv[2]), json.load(sys.stdin)
names, shown, seen = {"__name__": "__main__", "__file__": file}, [], set()
for code in cells:
    said = io.StringIO()
    with redirect_stdout(said):
        exec(compile(code, file, "exec"), names)
    drawn = sorted(str(path) for path in folder.rglob("*.png") if path not in seen)
    seen |= {Path(path) for path in drawn}
    shown.append([said.getvalue(), drawn])
json.dump(shown, sys.stdout)
"""


@dataclass(frozen=True)
class Shown:
    """What a cell printed, and the pictures that it wrote."""

    output: str
    pictures: tuple[Path, ...]


def split(text: str) -> list[tuple[str, str]]:
    """("words" or "code", text) of a script: its docstring, then its cells, in order."""
    start = re.match(r'"""(.*?)"""\n', text, re.DOTALL)
    found = [("words", start[1].strip())] if start else []
    for cell in re.split(r"^# %%", text[start.end() if start else 0 :], flags=re.MULTILINE)[1:]:
        head, _, body = cell.partition("\n")
        if "[markdown]" in head:
            found.append(("words", "\n".join(line.removeprefix("#").removeprefix(" ") for line in body.strip().splitlines())))
        else:
            found.append(("code", body.strip()))
    return found


def run(cells: list[str], folder: Path, file: Path | None = None) -> list[Shown]:
    """Run pieces of code in one process of its own, with a folder for what they write; a failure fails the documentation."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-c", _RUNNER, str(file or folder / "script.py"), str(folder)]
    done = subprocess.run(
        command, cwd=folder, env=environment, input=json.dumps(cells), capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{file or cells[0]!r} fails:\n{done.stderr}")
    told = re.compile(re.escape(str(folder)) + r"/(tmp\w+/)?")  # where it happened to run tells a reader nothing
    return [Shown(told.sub("", output), tuple(map(Path, pictures))) for output, pictures in json.loads(done.stdout)]


def fenced(text: str, language: str = "") -> str:
    """A block of code or output; nothing of nothing."""
    return f"```{language}\n{text.rstrip()}\n```" if text.strip() else ""
