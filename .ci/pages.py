"""Whether what the pages teach works where nothing but the wheel is installed: every tutorial, and the how-to page's commands and code.

`.ci/wheel --pages` installs the wheel and calls this with the folder of the project, of which it takes the pages alone.
"""

from __future__ import annotations

import os
import re
import resource
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

INSTALLED = Path(sys.prefix) / "share" / "ffrf-toolkit"
PLACEHOLDERS = {
    "section.dat": "models/morphing_wing/high_speed.dat",
    "body.msh": "models/bracket/bracket.msh",
    "hub": "crank",
    "tip": "pin",
    "body.toml": "models/bracket/body.toml",
    "scene.toml": "my_linkage/scene.toml",
    "study.toml": "models/morphing_wing/study.toml",
}
"""What stands on the page for files of the reader -> what is there."""
ON = {
    "tradeoff": "my_linkage",
    "certify": "my_linkage",
    "stability": "models/pendulum",
    "check-deformation": "my_wing",
    "statics": "my_wing",
}
"""Commands that the page names without a scene -> the folder of one."""
BRIEFLY = {"sweep": ["--points", "sobol", "--count", "8"], "tradeoff": ["--axes", "step"]}
"""What a command needs besides, or takes to be done soon."""


def how_to(page: str) -> Iterator[list[str]]:
    """Commands of the page in its order: those of blocks, and those within the text."""
    for language, block, inline in re.findall(r"^```(\w*)\n(.*?)^```|`(ffrf[^`\n]*)`", page, re.MULTILINE | re.DOTALL):
        for line in (block if not language else "").splitlines() + inline.splitlines():
            program, *words = [PLACEHOLDERS.get(word, word) for word in shlex.split(line, comments=True)]
            if len(words) == 1 and words[0] in ON:
                words.append(f"{ON[words[0]]}/scene.toml")
            if words and (program != "ffrf" or len(words) > 1 or words == ["warm-up"]):
                yield [program, *words, *BRIEFLY.get(words[0], [])]


def run(what: str, command: list[str], environment: dict[str, str]) -> tuple[float, bool]:
    """Seconds of processor time of a process, and whether it succeeded."""
    begun = processor_time()
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    seconds = processor_time() - begun
    print(f"{seconds:6.1f} s  {what}", flush=True)
    if done.returncode:
        print(f"{done.stdout}\n{done.stderr}\nfailed with exit code {done.returncode}", flush=True)
    return seconds, not done.returncode


def processor_time() -> float:
    """Seconds that all processes have taken which this one has started and that have ended: a busy machine does not make them more."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main(project: Path) -> None:
    """Copy the pages beside the models that came with the wheel, run all of them there, and fail if one of them fails."""
    shutil.copytree(INSTALLED / "models", "models")
    shutil.copytree(project / "tutorials", "tutorials")
    page = (project / "docs" / "how-to.md").read_text(encoding="utf-8")
    Path("how_to.py").write_text("\n".join(re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)))
    found = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "MPLBACKEND": "agg"}
    once = {shlex.join(command): command for command in how_to(page)}
    done = [run(name, command, found) for name, command in once.items()]
    scripts = [Path("how_to.py"), *sorted(Path("tutorials").glob("*.py"))]
    done += [run(str(script), [sys.executable, "-P", str(script)], found) for script in scripts]
    failed = sum(not succeeded for _, succeeded in done)
    print(
        f"{len(done)} commands and scripts in {sum(seconds for seconds, _ in done) / 60:.1f} minutes of processor time, {failed} failed"
    )
    sys.exit(failed > 0)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
