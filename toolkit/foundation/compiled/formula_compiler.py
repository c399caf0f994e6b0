"""numba's compiler, without what costs it time and formulas do not need."""

from __future__ import annotations

from typing import Any

from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import NopythonRewrites

from toolkit.foundation.compiled.known_typing import known_typing

NEEDLESS = (NopythonRewrites,)
"""Steps that are left out: this one joins operations with whole arrays, whose results would have to be allocated."""


class KnownFlags(Flags):
    """Settings of the compiler that never change, one for all formulas that have the same.

    At every index and operation numba looks up what it has made for such settings. Measured, to compare all their values takes a tenth of
    the time to compile.
    """

    def copy(self) -> KnownFlags:
        """Itself."""
        return self

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other


_KNOWN: dict[str, KnownFlags] = {}


class FormulaCompiler(Compiler):
    """numba's compiler, for formulas.

    Parameters
    ----------
    typing, target, library, arguments, result, flags, names : as numba's own takes them; `flags` are the settings
    """

    def __init__(self, typing: Any, target: Any, library: Any, arguments: Any, result: Any, flags: Flags, names: Any) -> None:
        known = _KNOWN.setdefault(flags.summary(), KnownFlags(flags))
        super().__init__(known_typing(typing), target, library, arguments, result, known, names)

    def define_pipelines(self) -> list[PassManager]:
        """Those of numba, without what is needless."""
        pipelines: list[PassManager] = super().define_pipelines()
        for each in pipelines:
            each.passes = [step for step in each.passes if step[0] not in NEEDLESS]
            each.finalize()
        return pipelines
