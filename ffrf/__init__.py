"""Flexible multibody dynamics with exact design sensitivities: the public names.

    import ffrf

    model = ffrf.compile(ffrf.read_scene("wing.toml"), variables=["t_w", "M_t"])
    run = model.simulate(gradients=True)
    run.values["max_stress"], run.gradients["max_stress"]["t_w"], run.verdict

Those of the runtime are loaded when they are first used, and so is `ffrf.preprocessing`, which builds the reduced models of bodies.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ffrf import preprocessing
    from toolkit import *  # noqa: F403

_HOME = Path(__file__).resolve().parents[1]
"""Folder that holds both halves of the program, and this package."""


def _refuse_namesake(half: str) -> None:
    """Raise an ImportError that names both where Python finds another package with the name of a half of the program."""
    spec = find_spec(half)
    places = (spec.submodule_search_locations or [spec.origin or half]) if spec else []
    found = [str(Path(place).resolve()) for place in places]
    if found != [str(_HOME / half)]:
        raise ImportError(
            f"{half!r} is not the half of ffrf-toolkit, {str(_HOME / half)!r}, but {' and '.join(found) or 'nothing'}, which comes before "
            "it on Python's path. Take its folder out of PYTHONPATH, or rename it."
        )


_refuse_namesake("toolkit")
_toolkit = import_module("toolkit")
__all__ = [*_toolkit.__all__, "preprocessing"]


def __getattr__(name: str) -> Any:
    if name in _toolkit.__all__ or name == "__version__":
        return getattr(_toolkit, name)
    if name != "preprocessing":
        from toolkit.foundation.errors import meant

        raise AttributeError(f"ffrf has no {name!r}{meant(name, __all__)}; it has: {', '.join(__all__)}")
    return import_module("ffrf.preprocessing")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
