"""Write the JSON schemas of scene, skin, body, frame and study files beside this script, from the classes that read those files.

Run it after a change of those classes: python schemas/write_schemas.py
"""

import json
from pathlib import Path

from preprocessing.builders.body_file import BodyFile
from preprocessing.builders.frame_file import FrameFile
from preprocessing.builders.skin_file import SkinFile
from toolkit.foundation.files.replaced_file import replaced
from toolkit.scene_file.schema import DRAFT, scene_schema, tidy
from toolkit.studies.study.study_file import Study

skin = tidy({"$schema": DRAFT, **SkinFile.model_json_schema(), "title": "A flexible skin of ffrf-toolkit"})
body = tidy(
    {"$schema": DRAFT, **BodyFile.model_json_schema(), "title": "A flexible body of ffrf-toolkit from a mesh or matrices"}
)
frame = tidy({"$schema": DRAFT, **FrameFile.model_json_schema(), "title": "A frame of beams of ffrf-toolkit"})
study = tidy({"$schema": DRAFT, **Study.model_json_schema(), "title": "A study of ffrf-toolkit: many designs of one scene"})
study["properties"].pop("directory")
schemas = {"scene": scene_schema(), "skin": skin, "body": body, "frame": frame, "study": study}
texts = {name: json.dumps(schema, indent=1) + "\n" for name, schema in schemas.items()}

if __name__ == "__main__":
    for name, text in texts.items():
        path = Path(__file__).with_name(f"{name}.json")
        with replaced(path) as temporary:
            temporary.write_text(text)
        print(f"{path} written.")
