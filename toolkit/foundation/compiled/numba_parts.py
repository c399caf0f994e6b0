"""Private parts of numba, which any release may change: its compiler without what costs time and formulas do not need, inner formulas that
stay as LLVM reads them, and code that is kept. Where they are missing, or newer than `TESTED`, formulas are compiled by `public_parts`.

numba optimises and translates every formula by itself, and again in everyone that calls it. Measured, a third of the time to compile the
step loop is saved when those that have no entrance are left as they are.
"""

from __future__ import annotations

import operator
import pickle
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from functools import update_wrapper
from typing import Any, ClassVar

from llvmlite.binding import Linkage, ModuleRef, parse_bitcode
from numba.core import cpu, event
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import Compiler, CompileResult, Flags, compile_result
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.core.types import Function, Type
from numba.core.typing import Context, Signature


class KnownResults(Context):  # type: ignore[misc]
    """numba's knowledge of types, with a memory for its own functions and operators.

    For every sum of two numbers numba tries all that it can add, and words why each failed; measured, that takes a sixth of the time to
    compile. What the same function makes of the same types never changes.

    Parameters
    ----------
    known : what numba knows, which it goes on learning here
    """

    results: ClassVar[dict[tuple, Signature]] = {}

    def __init__(self, known: Context) -> None:
        self.__dict__ = known.__dict__

    def resolve_function_type(self, func: Type, args: tuple[Type, ...], kws: Mapping[str, Type]) -> Signature | None:
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

    def resolve_setitem(self, target: Type, index: Type, value: Type) -> Signature | None:
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

    def get_call_type(self, context: Context, args: tuple[Type, ...], kws: Mapping[str, Type]) -> Signature | None:
        """Signature of the operator for types of arguments."""
        return context.resolve_function_type(self.known, args, kws)


class KnownOperators(KnownResults):
    """Types of operators for the step that writes code, which asks the operator anew for every operation."""

    def resolve_value_type(self, val: object) -> Type:
        """Type of an operator, one that remembers its results."""
        found = super().resolve_value_type(val)
        return KnownOperator.of(found) if type(found) is Function else found


class FormulaCompiler(Compiler):
    """numba's compiler, adapted to formulas.

    Parameters
    ----------
    typing, target, library, arguments, result, flags, names : as numba's own takes them; `flags` are the settings
    """

    def __init__(
        self,
        typing: Context,
        target: cpu.CPUContext,
        library: JITCodeLibrary | None,
        arguments: tuple[Type, ...],
        result: Type | None,
        flags: Flags,
        names: Mapping[str, Type],
    ) -> None:
        super().__init__(KnownResults(typing), target, library, arguments, result, flags, names)
        self.state.targetctx.typing_context = KnownOperators(typing)  # of a copy, for this formula alone


class InnerCode(JITCodeLibrary):
    """A library of numba that is linked into others and never runs by itself."""

    @classmethod
    def kept(cls, codegen: JITCPUCodegen, found: tuple[str, bytes]) -> InnerCode:
        """Library of a formula, from what `serialize_using_object_code` wrote."""
        name, bitcode = found
        library = cls(codegen, name)
        library._shared_module, library._finalized = parse_bitcode(bitcode), True
        return library

    def finalize(self) -> None:
        """Link what the formula calls, and leave it at that."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            if hasattr(self, "_reload_init"):  # since numba 0.62
                self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True

    def _get_module_for_linking(self) -> ModuleRef:
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
    def codegen(self) -> InnerCode:
        """Code generator that numba tells where constants of the formula are; they are in the code of those that call it."""
        return self

    def set_env(self, name: str, environment: object) -> None:
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

    def __init__(self, typing: Context, target: cpu.CPUContext, library: JITCodeLibrary | None, *rest: Any) -> None:
        library = library or InnerCode(target.codegen(), "inner")
        library.enable_object_caching()
        super().__init__(typing, target, library, *rest)


class KeptCode(JITCodeLibrary):
    """A library of numba whose code runs at once; what others need in order to take it in is read when they ask for it.

    Measured, a command that finds its formulas compiled spends a tenth of its time with reading that for nobody.
    """

    _bitcode: bytes = b""

    @classmethod
    def kept(cls, codegen: JITCPUCodegen, found: tuple[str, list[str], bytes, bytes]) -> KeptCode:
        """Library of a kernel, from what `bytes_of` took apart."""
        name, defined, code, bitcode = found
        library = cls(codegen, name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._bitcode = bitcode
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(defined)
        return library

    def _get_module_for_linking(self) -> ModuleRef:
        if self._shared_module is None:
            self._shared_module = parse_bitcode(self._bitcode)
        return self._shared_module


def bytes_of(compiled: Any) -> bytes:
    """Parts of a compiled formula that `restored` needs, as they are written."""
    library, *rest = compiled._replace(type_annotation="")._reduce()
    if not isinstance(compiled.library, InnerCode):
        name, _, (code, bitcode) = library
        module = compiled.library._get_module_for_linking()
        symbols = [*module.functions, *module.global_variables]
        library = name, sorted(each.name for each in symbols if not each.is_declaration), code, bitcode
    return dumps((library, *rest))


def restored(target: cpu.CPUContext, content: bytes, inner: bool) -> CompileResult:
    """Compiled formula in a process whose target is this, from its `bytes_of`; `inner` if only other kernels call it."""
    parts = pickle.loads(content)  # noqa: S301  trusted as the program is
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
    store : class of its code on disk, see `CompiledCode`
    """

    def __init__(self, function: Callable, options: Mapping[str, object], store: Callable[[InnerFormula], object]) -> None:
        self.py_func, self.targetoptions, self._store = function, {**options, **COMPILED}, store
        update_wrapper(self, function)

    def __getattr__(self, name: str) -> object:
        """Attribute that is there once the formula is ready to be compiled; one thread makes it so, others wait."""
        if not name.startswith("__"):
            with global_compiler_lock:
                if "_cache" not in vars(self):
                    self._cache = None
                    super().__init__(self.py_func, targetoptions=self.targetoptions, pipeline_class=InnerCompiler)
                    self._cache = self._store(self)
        return object.__getattribute__(self, name)

    def __call__(self, *_arguments: object, **_named: object) -> None:
        """Refuse a call: there is no code that Python could call."""
        name = self.py_func.__name__
        raise TypeError(f"{name} is a formula that only other kernels call. Call plain({name}), or decorate it by kernel.")

    def _insert(self, *_found: object) -> None:
        """Do nothing, since there is no entrance for Python's calls."""


def announced(watch: object) -> AbstractContextManager[None]:
    """Block in which numba tells a `CompileWatch` of every function that it compiles; one that is loaded from the disk is none."""
    event.Listener.register(type(watch))
    install: Any = event.install_listener
    found: AbstractContextManager[None] = install("numba:compile", watch)
    return found
