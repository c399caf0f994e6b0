"""What numba has found out about its own operations, asked for once and not at every place where formulas use them."""

from __future__ import annotations

import operator
from functools import cache
from typing import Any

from numba.core import types
from numba.core.typing.context import BaseContext

OPERATIONS = {each for each in vars(operator).values() if callable(each)}


class KnownTyping(BaseContext):
    """numba's own knowledge of types, which it shares, with the answers for operations with numbers and arrays kept.

    numba tries all that it knows of an operation in turn, and writes a report for everything that does not fit. Measured, that is a tenth
    of the time to compile.

    Parameters
    ----------
    own : BaseContext
        numba's.
    """

    def __init__(self, own: BaseContext) -> None:
        self.__dict__ = own.__dict__

    def load_additional_registries(self) -> None:
        """Nothing: numba's own has loaded them."""

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """Signature of a function for types of arguments."""
        if kws or not _is_operation(func):
            return super().resolve_function_type(func, args, kws)
        key = func, tuple(args)
        if key not in _ANSWERS:
            found = super().resolve_function_type(func, args, kws)
            if found is None:  # where types are not known yet
                return None
            _ANSWERS[key] = found
        return _ANSWERS[key]


_ANSWERS: dict[Any, Any] = {}


@cache
def known_typing(own: BaseContext) -> KnownTyping:
    """The one for that of numba; its functions of numpy are compiled for each."""
    return own if isinstance(own, KnownTyping) else KnownTyping(own)


def _is_operation(func: Any) -> bool:
    """Whether it is one of numba's own, which compile nothing of ours."""
    return (func.typing_key if type(func) is types.Function else func) in OPERATIONS
