"""Code of formulas that only other kernels call: handed on to these as LLVM reads it, and made for the processor there alone.

numba optimises and translates every formula by itself, and again in everyone that calls it. Measured, a third of the time to compile the
step loop is saved when those that have no entrance are left as they are.
"""

from __future__ import annotations

from typing import Any

from llvmlite.binding import Linkage, parse_bitcode
from numba.core.codegen import JITCodeLibrary

from toolkit.foundation.compiled.formula_compiler import FormulaCompiler


class InnerCode(JITCodeLibrary):
    """A library of numba that is linked into others and never runs by itself."""

    @classmethod
    def kept(cls, codegen: Any, found: tuple[str, bytes]) -> InnerCode:
        """Library of a formula, from what `serialize_using_object_code` wrote."""
        name, bitcode = found
        library = cls(codegen, name)
        library._shared_module, library._finalized = parse_bitcode(bitcode), True
        return library

    def _optimize_functions(self, module: Any) -> None:
        """Optimise the functions that are in the module.

        From numba 0.62 on a list of passes is made for each function that is only named there too.
        """
        if not hasattr(self._codegen, "_pass_builder"):
            super()._optimize_functions(module)
            return
        module.data_layout = self._codegen._data_layout
        manager, builder = self._codegen._function_pass_manager()
        for function in module.functions:
            if not function.is_declaration:
                manager.run(function, builder)

    def finalize(self) -> None:
        """Link what the formula calls, and leave it at that."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            if hasattr(self, "_reload_init"):  # since numba 0.62
                self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Code of the formula itself, not a copy of it.

        Callers may have it several times, and leave out what nobody calls.
        """
        if self._shared_module is None:
            self._ensure_finalized()
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == Linkage.external:
                    function.linkage = Linkage.linkonce_odr
            self._shared_module = self._final_module
        return self._shared_module

    @property
    def codegen(self) -> Any:
        """Code generator that numba tells where constants of the formula are; they are in the code of those that call it."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing, since there is no place for an environment yet."""

    def get_pointer_to_function(self, name: str) -> int:
        """Zero as the address, since there is no code for the processor."""
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> tuple[str, bytes]:
        """Name and bitcode of the formula, which are kept: there is no object code."""
        return self.name, self._get_module_for_linking().as_bitcode()


class InnerCompiler(FormulaCompiler):
    """A compiler whose result is an `InnerCode`."""

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        library = library or InnerCode(target.codegen(), "inner")
        library.enable_object_caching()
        super().__init__(typing, target, library, *rest)
