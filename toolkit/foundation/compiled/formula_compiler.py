"""numba's compiler, without what costs it time and formulas do not need."""

from __future__ import annotations

import operator
from types import CodeType
from typing import Any, ClassVar

from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import AnnotateTypes, IRLegalization, NopythonRewrites
from numba.core.types import Function
from numba.core.typing.context import Context
from numba.core.untyped_passes import InlineClosureLikes

NEEDLESS = (NopythonRewrites, IRLegalization, AnnotateTypes)
"""Steps that are left out. The first joins operations with whole arrays, whose results would have to be allocated; the second marks where
variables are needed no more, so that what is counted could be given back: formulas count nothing; the third words types for readers."""
CLOSURES = (InlineClosureLikes,)
"""Steps for functions inside of a function, of which most formulas have none."""


class KnownFlags(Flags):
    """Settings of the compiler that never change, one for all formulas that have the same.

    At every index and operation numba looks up what it has made for such settings. Measured, to compare all their values takes a tenth of
    the time to compile.
    """

    def copy(self) -> KnownFlags:
        """The same settings, since they never change."""
        return self

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other


_KNOWN: dict[str, KnownFlags] = {}


class KnownResults(Context):  # type: ignore[misc]
    """numba's knowledge of types, with a memory for its own functions and operators.

    For every sum of two numbers numba tries all that it can add, and words why each failed; measured, that takes a sixth of the time to
    compile. What the same function makes of the same types never changes.

    Parameters
    ----------
    known : what numba knows, which it goes on learning here
    """

    results: ClassVar[dict[tuple, Any]] = {}

    def __init__(self, known: Context) -> None:
        self.__dict__ = known.__dict__

    def resolve_function_type(self, func: Any, args: tuple, kws: dict[str, Any]) -> Any:
        """Signature of a function for types of arguments."""
        if type(func) is not Function:
            return super().resolve_function_type(func, args, kws)
        call = (func, args, tuple(kws.items()))
        if call not in self.results:
            found = super().resolve_function_type(func, args, kws)
            if found is None:  # nothing fits yet, which is no answer for ever
                return None
            self.results[call] = found
        return self.results[call]

    def resolve_setitem(self, target: Any, index: Any, value: Any) -> Any:
        """Signature of a written entry."""
        return self.resolve_function_type(super().resolve_value_type(operator.setitem), (target, index, value), {})


class KnownOperator(Function):
    """An operator that looks up what it makes of types in the memory of the one who asks."""

    known: Function

    @classmethod
    def of(cls, known: Function) -> KnownOperator:
        """Operator with all that numba knows of it; no type of its own among those of numba."""
        found: KnownOperator = object.__new__(cls)
        found.__dict__ = {**vars(known), "known": known}
        return found

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Signature of the operator for types of arguments."""
        return context.resolve_function_type(self.known, args, kws)


class KnownOperators(KnownResults):
    """Types of operators for the step that writes code, which asks the operator anew for every operation."""

    def resolve_value_type(self, val: Any) -> Any:
        """Type of an operator, one that remembers its results."""
        found = super().resolve_value_type(val)
        return KnownOperator.of(found) if type(found) is Function else found


class FormulaCompiler(Compiler):
    """numba's compiler, adapted to formulas.

    Parameters
    ----------
    typing, target, library, arguments, result, flags, names : as numba's own takes them; `flags` are the settings
    """

    def __init__(self, typing: Any, target: Any, library: Any, arguments: Any, result: Any, flags: Flags, names: Any) -> None:
        known = _KNOWN.setdefault(flags.summary(), KnownFlags(flags))
        super().__init__(KnownResults(typing), target, library, arguments, result, known, names)
        own = self.state.targetctx  # a copy, for this formula alone
        own.typing_context = KnownOperators(typing)
        own.refresh = _nothing  # it has just looked for what is new, and would do so again for every array

    def define_pipelines(self) -> list[PassManager]:
        """Pipelines of numba's compiler without the passes that formulas do not need."""
        pipelines: list[PassManager] = super().define_pipelines()
        inside = any(isinstance(each, CodeType) for each in self.state.func_id.code.co_consts)
        left_out = NEEDLESS if inside else NEEDLESS + CLOSURES
        for each in pipelines:
            each.passes = [step for step in each.passes if step[0] not in left_out]
            each.finalize()
        return pipelines


def _nothing() -> None:
    """Do nothing, since the work is done already."""
