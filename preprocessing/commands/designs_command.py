"""The program behind the end-to-end part of `ffrf certify` and `ffrf tradeoff`: reduced models of many designs of one body, in one process.

`python -m preprocessing.commands.designs_command SKIN.toml`; every line of its input is a JSON object

    {"file": ..., "values": {parameter: value}, "keys": {key of skin.toml: value}}

of which the last two can be left out, and every line of its output one {"file": ..., "tables": {...}} with the tables of skin.toml that
other keys have changed.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from preprocessing.builders.build_model import read_recipe
from toolkit.foundation.errors import ToolkitError, refusal
from toolkit.reduced_model.file import save


def main(skin: Path) -> None:
    """Build the models of all designs; an error becomes one message and exit code 1."""
    for line in sys.stdin:
        wanted = json.loads(line)
        try:
            recipe = read_recipe(skin)
            other = recipe.at(wanted.get("values"), wanted.get("keys"))
            save(other.build(), wanted["file"])
            tables = recipe.changed_tables(other) if other.keys else {}
        except ToolkitError as error:
            print(error, file=sys.stderr)
            raise SystemExit(1) from None
        except OSError as error:
            print(refusal(error), file=sys.stderr)
            raise SystemExit(1) from None
        print(json.dumps({"file": wanted["file"], "tables": tables}), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
