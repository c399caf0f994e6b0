"""From an airfoil, a mesh or beams to the reduced model of a flexible body: the public names of `preprocessing`.

    from ffrf.preprocessing import build, save

Each is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ffrf import _refuse_namesake

if TYPE_CHECKING:
    from preprocessing import *  # noqa: F403

_refuse_namesake("preprocessing")
_preprocessing = import_module("preprocessing")
__all__ = list(_preprocessing.__all__)


def __getattr__(name: str) -> Any:
    return getattr(_preprocessing, name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
