"""The program behind the end-to-end part of `ffrf certify`: reduced models of many designs of one skin, in one process.

`python -m preprocessing.designs_command SKIN.toml`; every line of its input is a JSON object {"file": ..., "values": {parameter: value}},
every line of its output the file that was written.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from preprocessing.build import build
from toolkit.errors import ToolkitError
from toolkit.reduced_model_file import save


def main(skin: Path) -> None:
    """Build them all; an error becomes one message and exit code 1."""
    for line in sys.stdin:
        wanted = json.loads(line)
        try:
            save(build(skin, values=wanted["values"]), wanted["file"])
        except ToolkitError as error:
            print(error, file=sys.stderr)
            raise SystemExit(1) from None
        print(wanted["file"], flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
