"""The runtime: loads reduced models, integrates scenes, and carries design sensitivities along.

Its public names are those of `ffrf`. Each is loaded when it is first used, so that importing it costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toolkit import air, bridges
    from toolkit.analyses.sensitivity.certificate.certificate import certify
    from toolkit.analyses.sensitivity.run import Run, load
    from toolkit.api import extend, plane, space
    from toolkit.api.describe import describe
    from toolkit.api.many_designs import optimize, sweep, uncertainty
    from toolkit.api.model import Model
    from toolkit.api.model import compile_model as compile
    from toolkit.api.outcome import Outcome
    from toolkit.description.run_options import RunOptions
    from toolkit.files.scene_reader import read_scene
    from toolkit.foundation.errors import ToolkitError
    from toolkit.foundation.verdict import Caution, Verdict
    from toolkit.scene.scene import Scene
    from toolkit.studies.optimization.optimum import Optimum
    from toolkit.studies.study_file import Study, read_study
    from toolkit.studies.sweep import Swept
    from toolkit.studies.uncertain_result import UncertainResult

_PLACES = {
    "Caution": "toolkit.foundation.verdict:Caution",
    "Model": "toolkit.api.model:Model",
    "Optimum": "toolkit.studies.optimization.optimum:Optimum",
    "Outcome": "toolkit.api.outcome:Outcome",
    "Run": "toolkit.analyses.sensitivity.run:Run",
    "RunOptions": "toolkit.description.run_options:RunOptions",
    "Scene": "toolkit.scene.scene:Scene",
    "Study": "toolkit.studies.study_file:Study",
    "Swept": "toolkit.studies.sweep:Swept",
    "ToolkitError": "toolkit.foundation.errors:ToolkitError",
    "UncertainResult": "toolkit.studies.uncertain_result:UncertainResult",
    "Verdict": "toolkit.foundation.verdict:Verdict",
    "air": "toolkit.air:",
    "bridges": "toolkit.bridges:",
    "certify": "toolkit.analyses.sensitivity.certificate.certificate:certify",
    "compile": "toolkit.api.model:compile_model",
    "describe": "toolkit.api.describe:describe",
    "extend": "toolkit.api.extend:",
    "load": "toolkit.analyses.sensitivity.run:load",
    "optimize": "toolkit.api.many_designs:optimize",
    "plane": "toolkit.api.plane:",
    "read_scene": "toolkit.files.scene_reader:read_scene",
    "read_study": "toolkit.studies.study_file:read_study",
    "space": "toolkit.api.space:",
    "sweep": "toolkit.api.many_designs:sweep",
    "uncertainty": "toolkit.api.many_designs:uncertainty",
}
"""Name -> module and what it is called there; without a name the module itself."""

__all__ = [
    "Caution",
    "Model",
    "Optimum",
    "Outcome",
    "Run",
    "RunOptions",
    "Scene",
    "Study",
    "Swept",
    "ToolkitError",
    "UncertainResult",
    "Verdict",
    "air",
    "bridges",
    "certify",
    "compile",
    "describe",
    "extend",
    "load",
    "optimize",
    "plane",
    "read_scene",
    "read_study",
    "space",
    "sweep",
    "uncertainty",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version  # which takes longer to import than all else here

        return version("ffrf-toolkit")
    if name not in _PLACES:
        from toolkit.foundation.errors import meant

        raise AttributeError(f"ffrf has no {name!r}{meant(name, _PLACES)}; it has: {', '.join(_PLACES)}")
    module, _, attribute = _PLACES[name].partition(":")
    found = import_module(module)
    return getattr(found, attribute) if attribute else found


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
