"""Code of a formula from the disk, and what numba has to know of it."""

from __future__ import annotations

from typing import Any

from llvmlite.binding import parse_bitcode
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult, compile_result

from toolkit.foundation.compiled.inner_code import InnerCode


class KeptCode(JITCodeLibrary):
    """A library of numba whose code runs at once; what others need in order to take it in is read when they ask for it.

    Measured, a command that finds its formulas compiled spends a tenth of its time with reading that for nobody.
    """

    _bitcode: bytes = b""

    @classmethod
    def kept(cls, codegen: Any, found: tuple[str, list[str], bytes, bytes]) -> KeptCode:
        """The library that `parts_of` took apart."""
        name, defined, code, bitcode = found
        library = cls(codegen, name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._bitcode = bitcode
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(defined)
        return library

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = parse_bitcode(self._bitcode)
        return self._shared_module


def parts_of(compiled: Any) -> tuple:
    """All that `restored` needs, ready to be written."""
    library, *rest = compiled._reduce()
    if not isinstance(compiled.library, InnerCode):
        name, _, (code, bitcode) = library
        module = compiled.library._get_module_for_linking()
        symbols = [*module.functions, *module.global_variables]
        library = name, sorted(each.name for each in symbols if not each.is_declaration), code, bitcode
    return library, *rest


def restored(target: Any, parts: tuple, inner: bool) -> CompileResult:
    """A compiled formula in a process whose target is this; `inner` if only other kernels call it."""
    found, description, environment, signature, objectmode, lifted, annotation, reload_init, referenced = parts
    for function in reload_init:
        function()
    library = (InnerCode if inner else KeptCode).kept(target.codegen(), found)
    entry = target.get_executable(library, description, environment)
    for each in referenced:
        library.codegen.set_env(each.env_name, each)
    return compile_result(
        target_context=target,
        typing_context=target.typing_context,
        library=library,
        environment=environment,
        entry_point=entry,
        fndesc=description,
        type_annotation=annotation,
        signature=signature,
        objectmode=objectmode,
        lifted=lifted,
        reload_init=reload_init,
        referenced_envs=referenced,
    )
