"""Feeds spoilt HDF5 files to the program, in a process of its own because HDF5 itself could crash.

Run as python -m tests.fuzz.hdf5_batch FOLDER KIND [COUNT SEED]. The folder holds `good.h5` and, for a model, `scene.toml`.
Every line of the output is one case and what came of it. With a count there are so many files whose checksums are all right,
instead of the usual batch.
"""

from __future__ import annotations

import resource
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

import numpy as np

from tests.fuzz.hostile_hdf5 import spoilt_attributes, spoilt_bytes, spoilt_objects
from tests.fuzz.sealed_hdf5 import sealed_files
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare, solve
from toolkit.api.describe import describe
from toolkit.command_line.commands.inspection import describe_results
from toolkit.files.results import restore_scene
from toolkit.files.results_file import load_results, refuse_foreign
from toolkit.files.scene_reader import read_scene
from toolkit.files.tables import export_csv
from toolkit.foundation.errors import ToolkitError
from toolkit.reduced_model.file import is_reduced_model

MODEL_OBJECTS = ["invariants", "invariants/stiffness", "invariants/inertia", "invariants/mass", "derivatives",
                 "derivatives/shape.target/entry", "affine/stiffness/power", "affine/stiffness/factor", "affine/stiffness/entry",
                 "affine/stiffness/value", "interfaces", "interfaces/tip/position",
                 "shape/target", "mesh/connectivity", "nominal", "sections/axis", "sections/bending_stiffness",
                 "section_affine/sections.axial_stiffness/factor"]  # fmt: skip
MODEL_ATTRIBUTES = ["/@schema", "/@schema_version", "/@dimension", "/@units", "/@basis", "nominal@thickness", "nominal_units@thickness",
                    "writers@numpy"]  # fmt: skip
RESULTS_OBJECTS = ["times", "q", "dq", "about", "scene_text", "names/coordinates", "names", "bodies", "bodies/beam/stress",
                   "bodies/beam/element"]  # fmt: skip
RESULTS_ATTRIBUTES = ["/@schema", "/@schema_version"]


def use_model(path: Path) -> None:
    """All that is done with a model that was accepted."""
    is_reduced_model(path)
    describe(path)
    system = prepare(read_scene(path.with_name("scene.toml")), ["bodies.beam.thickness"])
    for kind in ("transient", "static"):
        evaluate_responses(solve(system, kind))


def use_results(path: Path) -> None:
    """All that is done with results that were accepted."""
    refuse_foreign(path)
    results = load_results(path)
    describe_results(results)
    restore_scene(results)
    export_csv(results, path.parent)


def cases(folder: Path, kind: str) -> Iterator[str]:
    """The whole batch."""
    good, path = folder / "good.h5", folder / "case.h5"
    objects, attributes = (MODEL_OBJECTS, MODEL_ATTRIBUTES) if kind == "model" else (RESULTS_OBJECTS, RESULTS_ATTRIBUTES)
    parts = (
        spoilt_objects(good, path, objects),
        spoilt_attributes(good, path, attributes),
        spoilt_bytes(good, path, 50, 200, seed=1),
    )
    return chain(*parts)


def outcome(use: Callable[[Path], None], path: Path) -> str:
    """What came of one case."""
    try:
        use(path)
    except ToolkitError as error:
        return f"refused {type(error).__name__} {str(error)!r}"
    except BaseException:  # noqa: BLE001 (this is what is looked for)
        return f"ESCAPED {traceback.format_exc()!r}"
    return "accepted"


if __name__ == "__main__":
    warnings.simplefilter("error")
    np.seterr(all="warn", under="ignore")
    directory, what = Path(sys.argv[1]), sys.argv[2]
    wanted = [int(word) for word in sys.argv[3:]]
    every = sealed_files(directory / "good.h5", directory / "case.h5", *wanted) if wanted else cases(directory, what)
    for case in every:
        print(case, end=" -> ", flush=True)
        print(outcome(use_results if what == "results" else use_model, directory / "case.h5"), flush=True)
    print("memory", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
