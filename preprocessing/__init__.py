"""From an airfoil file to the reduced model of its flexible skin."""

from importlib.util import find_spec
from pathlib import Path

_SPEC, _OWN = find_spec("toolkit"), Path(__file__).resolve().parents[1] / "toolkit"
if _SPEC is None or _SPEC.origin is None or Path(_SPEC.origin).resolve().parent != _OWN:
    raise ImportError(
        f"'toolkit' is not the other half of this program, {str(_OWN)!r}, but {_SPEC and _SPEC.origin}, which comes before it on Python's "
        "path. Take its folder out of PYTHONPATH, or rename it."
    )
