"""A formula that only other kernels call, as numba knows it."""

from __future__ import annotations

from collections.abc import Callable
from functools import update_wrapper
from typing import Any

from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher

from toolkit.foundation.compiled.compiled_code import CompiledCode
from toolkit.foundation.compiled.inner_code import InnerCompiler

COMPILED = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "nopython": True, "boundscheck": None}
"""Options of numba for a formula without an entrance from Python."""


class InnerFormula(CPUDispatcher):
    """A formula without an entrance: a call from Python, which would end the process, is refused.

    numba makes it ready to be compiled when a caller is compiled, not before: a command that finds all callers compiled needs none of the
    three hundred inner formulas, and to make them ready took a twentieth of it.

    Parameters
    ----------
    function : the formula as plain Python
    options : of numba
    """

    def __init__(self, function: Callable, options: dict[str, Any]) -> None:
        self.py_func, self.targetoptions = function, {**options, **COMPILED}
        update_wrapper(self, function)

    def __getattr__(self, name: str) -> Any:
        """Attribute that is there once the formula is ready to be compiled; one thread makes it so, others wait."""
        if not name.startswith("__"):
            with global_compiler_lock:
                if "_cache" not in vars(self):
                    self._cache = None
                    super().__init__(self.py_func, targetoptions=self.targetoptions, pipeline_class=InnerCompiler)
                    self._cache = CompiledCode(self)
        return object.__getattribute__(self, name)

    def __call__(self, *_arguments: Any, **_named: Any) -> None:
        """Refuse a call: there is no code that Python could call."""
        name = self.py_func.__name__
        raise TypeError(f"{name} is a formula that only other kernels call. Call plain({name}), or decorate it by kernel.")

    def _insert(self, *_found: Any) -> None:
        """Do nothing, since there is no entrance for Python's calls."""
