"""Write the JSON schemas of scene, skin, body, frame and study files beside this script, from the classes that read those files.

Type checkers and editors of Python have what `ffrf.plane` and `ffrf.space` hold from two files that are written with them.

Run it after a change of those classes: python schemas/write_schemas.py
"""

import json
from pathlib import Path
from typing import Any

from preprocessing.builders.body_file import BodyFile
from preprocessing.builders.frame_file import FrameFile
from preprocessing.builders.skin_file import SkinFile
from toolkit.api.plane import parts_of_scenes
from toolkit.files.scene_schema import DRAFT, scene_schema, tidy
from toolkit.foundation.files.safe_files import replaced
from toolkit.studies.study_file import Study

WIDTH = 120
"""Characters of a line of a schema."""

skin = tidy({"$schema": DRAFT, **SkinFile.model_json_schema(), "title": "A flexible skin of ffrf-toolkit"})
body = tidy(
    {"$schema": DRAFT, **BodyFile.model_json_schema(), "title": "A flexible body of ffrf-toolkit from a mesh or matrices"}
)
frame = tidy({"$schema": DRAFT, **FrameFile.model_json_schema(), "title": "A frame of beams of ffrf-toolkit"})
study = tidy({"$schema": DRAFT, **Study.model_json_schema(), "title": "A study of ffrf-toolkit: many designs of one scene"})
study["properties"].pop("directory")
schemas = {"scene": scene_schema(), "skin": skin, "body": body, "frame": frame, "study": study}


def written(value: Any, depth: int = 0) -> str:
    """JSON of a value, on one line where it is short."""
    text = json.dumps(value)
    if depth + len(text) <= WIDTH or not isinstance(value, dict | list):
        return text
    items = [f"{json.dumps(key)}: {written(item, depth + 1)}" for key, item in value.items()] if isinstance(value, dict) else []
    items = items or [written(item, depth + 1) for item in value]
    first, last = "{}" if isinstance(value, dict) else "[]"
    return f"{first}\n" + ",\n".join(" " * (depth + 1) + item for item in items) + f"\n{' ' * depth}{last}"


def stub(dimension: int) -> str:
    """Names and classes of the parts of scenes of a dimension, as type checkers read them."""
    parts = parts_of_scenes(dimension)
    lines = [f"from {kind.__module__} import {kind.__name__} as {name}" for name, kind in parts.items()]
    lines += [
        "",
        "__all__ = [",
        *(f'    "{name}",' for name in parts),
        "]",
        "",
        "def parts_of_scenes(dimension: int) -> dict[str, type]: ...",
    ]
    return "\n".join(["# Written by schemas/write_schemas.py.", "# ruff: noqa", "# fmt: off", "", *lines, ""])


texts = {name: written(schema) + "\n" for name, schema in schemas.items()}
stubs = {"plane": stub(2), "space": stub(3)}
"""Name of a part of the door -> text of the file beside it for type checkers."""

if __name__ == "__main__":
    here = Path(__file__)
    files = {here.with_name(f"{name}.json"): text for name, text in texts.items()}
    files |= {here.parents[1] / "toolkit" / "api" / f"{name}.pyi": text for name, text in stubs.items()}
    for path, text in files.items():
        with replaced(path) as temporary:
            temporary.write_text(text)
        print(f"{path} written.")
