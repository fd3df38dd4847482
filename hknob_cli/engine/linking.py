"""Compiled functions linked into the one that Python calls, and optimised there, once.

Numba optimises a function with copies of all that it calls, makes it executable, and gives it a wrapper by which Python
calls it. Python calls few functions of the engine. The others are only ever called by these, so that this work on them
is repeated in each caller and used by none. Here a function exists twice: as a part of others, which is translated and
no more; and as an entry, into which all its parts are linked before it is optimised. Optimising does not reorder
arithmetic: results are the same to the last bit.

Numba counts the references to each array that a function is given, atomically, whenever it is called. Work space holds
dozens of arrays, and the small functions of the engine get it a million times: counting took more time than what they
do. Who calls the engine holds its arrays, so that a function that makes none does not count them.

A tuple is handed over number by number, and an array in it as seven. The body, the wall and the law of the general
loop are some two hundred, of which most functions use few. Parts of an entry are its own: nothing else can call them,
so that the optimiser leaves out what they do not use. As functions that another module might call they took all, and
the general loop under a controller spent nine tenths of its time on handing over. What is left is some fifty numbers,
which the processor copies in wider pieces than they were written in, and waits for: a sample took half as long again.
So what every sample goes through becomes a part of its callers (`INLINED`). The reverse is a division in a branch that
is rarely taken: the optimiser would do it each time, and choose afterwards (`ALONE`).

Numba finds the type of such a tuple in Python, number by number, at each call of an entry. That took longer than a
short search does; here a tuple like one that was seen before has its type. While it compiles, it finds out anew for
each sum and product which of its candidates takes two numbers: a sixth of the time. Here it is asked once. Half of
its steps are for what the engine does not have, a tenth of the time. They are left out. So is vectorising and unrolling
in the general loop, another tenth. The plain loop gains by both: it takes trials side by side, and its sets have
polygons of many corners.
"""

import contextlib
import gc
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.engine.absent import deciding

INLINED = ("decide", "advance_with_law", "turn_with_law", "move_piece_columns", "rub_columns", "end_of", "end_with_law")
ALONE = ("round_to_step",)
SCALAR = "hknob_cli.engine.general"  # loops in here gain nothing by being vectorised or unrolled
# Steps of numba's for what the engine does not have: `with`, closures, errors raised, loops over literals, inlining in
# Python, expressions of whole arrays. Each costs as much as one that does something.
NEEDLESS = (
    "WithLifting",
    "InlineClosureLikes",
    "RewriteDynamicRaises",
    "MakeFunctionToJitFunction",
    "InlineInlinables",
    "FindLiterallyCalls",
    "LiteralUnroll",
    "LiteralPropagationSubPipelinePass",
    "InlineOverloads",
    "NopythonRewrites",
    "DumpParforDiagnostics",
)


class Kinds(NamedTuple):
    """Classes derived from numba's, which is loaded here.

    ``part``: makes a part of a function; ``entry``: makes an entry; both are told whether it ``allocates`` arrays, or
    calls what does. ``pipeline``: of an entry, where numba makes it.
    """

    part: Callable[..., Any]
    entry: Callable[..., Any]
    pipeline: Any


def likeness(value: Any) -> Any:
    """What an argument of an entry has in common with all of its type: numbers below 2⁶³, arrays, laws, tuples."""
    kind = type(value)
    if kind is float:
        return kind
    if isinstance(value, tuple):
        return kind, *map(likeness, value)
    if kind is np.ndarray:
        return value.dtype, value.ndim, value.flags.num
    return value if callable(value) else kind


@contextlib.contextmanager
def in_haste() -> Iterator[None]:
    """Compile with what numba's own functions and operators return found out once for each types of arguments.

    And without looking for garbage, of which a compiler makes little: that would take a fifth of the time.
    """
    from numba.core.types import functions

    numbas: Any = functions.BaseFunction
    find, collecting = numbas.get_call_type, gc.isenabled()
    if find.__module__ == __name__:  # within another compilation
        yield
        return

    def remembered(self: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws:
            return find(self, context, args, kws)
        known = self.__dict__.setdefault("known_calls", {})
        if args not in known:
            known[args] = find(self, context, args, kws)
        return known[args]

    numbas.get_call_type = remembered
    gc.disable()
    try:
        yield
    finally:
        numbas.get_call_type = find
        if collecting:
            gc.enable()


@cache
def kinds() -> Kinds:
    """The kinds of compiled functions."""
    from llvmlite.binding import create_pass_builder, create_pipeline_tuning_options
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler
    from numba.core.compiler_machinery import PassManager
    from numba.core.environment import lookup_environment
    from numba.core.registry import CPUDispatcher
    from numba.core.types import unliteral
    from numba.core.untyped_passes import DeadBranchPrune

    types: dict[Any, Any] = {}  # by `likeness`

    class NotRun:
        """Numba's generator of code, where none is made."""

        @staticmethod
        def set_env(_name: str, _environment: Any) -> None:
            """A part has no place for it; `Entry` sets it."""

    class PartCode(JITCodeLibrary):
        """What is linked into entries: neither optimised nor executable, and without what it calls."""

        codegen = NotRun

        def _optimize_functions(self, module: Any) -> None:
            module.data_layout = self._codegen._data_layout
            wish = "alwaysinline" if self.name in INLINED else "noinline" if self.name in ALONE else None
            for function in module.functions if wish else ():
                if not function.is_declaration:
                    function.add_function_attribute(wish)

        def add_linking_library(self, library: Any) -> None:
            self._linking_libraries.append(library)

        def finalize(self) -> None:
            self._finalized = True

        def get_pointer_to_function(self, _name: str) -> int:
            self._ensure_finalized()
            return 0

    class EntryCode(JITCodeLibrary):
        """What is executable, with all that it calls."""

        scalar: bool  # whether its loops are neither vectorised nor unrolled

        def finalize(self) -> None:
            self._linking_libraries = callers_first(self._linking_libraries)
            super().finalize()

        def _optimize_final_module(self) -> None:
            # What others could call must take all that it is given; a part that only this entry calls, what it uses.
            for function in self._final_module.functions:
                if function.linkage.name == "linkonce_odr":
                    function.linkage = "internal"
            if not self.scalar:
                super()._optimize_final_module()
                return
            tuning = create_pipeline_tuning_options(speed_level=3)
            tuning.loop_unrolling = tuning.loop_interleaving = False
            tuning.loop_vectorization = tuning.slp_vectorization = False
            builder = create_pass_builder(self._codegen._tm, tuning)
            builder.getModulePassManager().run(self._final_module, builder)

        def _finalize_specific(self) -> None:
            super()._finalize_specific()
            code: Any = self._codegen
            for variable in self._final_module.global_variables:
                environment = lookup_environment(variable.name)
                if environment is not None:
                    code.set_env(variable.name, environment)

    def callers_first(libraries: list[Any]) -> list[Any]:
        """Libraries and all that they call, once each: what nothing calls yet would be left out of the entry."""
        found: dict[int, Any] = {}
        done: list[Any] = []

        def visit(library: Any) -> None:
            if id(library) in found:
                return
            found[id(library)] = library
            if isinstance(library, PartCode):
                for called in library._linking_libraries:
                    visit(called)
            done.append(library)

        for library in libraries:
            visit(library)
        return done[::-1]

    class Into(Compiler):
        """Numba's compiler, of code of another kind, without the steps that change nothing of the engine."""

        code: type

        def define_pipelines(self) -> list[Any]:
            """The default one, less the steps of `NEEDLESS`."""
            (usual,) = super().define_pipelines()
            manager, seen = PassManager("engine"), set()
            for step, text in usual.passes:
                if step is DeadBranchPrune and deciding() not in seen:
                    manager.add_pass(deciding(), "conditions that types decide")
                    seen.add(deciding())
                if step.__name__ not in NEEDLESS and step not in seen:
                    manager.add_pass(step, text)
                    seen.add(step)
            manager.finalize()
            return [manager]

        def compile_extra(self, function: Callable[..., Any]) -> Any:
            self.state.library = self.code(self.state.targetctx.codegen(), function.__qualname__)
            self.state.library.scalar = str(function.__module__).startswith(SCALAR)
            self.state.library.enable_object_caching()
            with in_haste():
                return super().compile_extra(function)

    class IntoPart(Into):
        code = PartCode

    class IntoEntry(Into):
        code = EntryCode

    class Part(CPUDispatcher):
        """A function that others call."""

        def __init__(self, function: Callable[..., Any], *, allocates: bool = False) -> None:
            options = {"nopython": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": allocates}
            super().__init__(function, targetoptions=options, pipeline_class=IntoPart)
            self.allocates = allocates

        def get_call_template(self, args: Any, kws: Any) -> Any:
            """As it is: a number written in the caller does not make it another function."""
            return super().get_call_template(tuple(map(unliteral, args)), kws)

    class Entry(CPUDispatcher):
        """A function that Python calls."""

        def __init__(self, function: Callable[..., Any], *, allocates: bool = False) -> None:
            options = {"nopython": True, "nogil": True, "no_cfunc_wrapper": True, "_nrt": allocates}
            super().__init__(function, targetoptions=options, pipeline_class=IntoEntry)

        def typeof_pyval(self, val: Any) -> Any:
            """The type of an argument that numba's C code does not know by itself."""
            like = likeness(val)
            found = types.get(like)
            if found is None:
                found = types[like] = super().typeof_pyval(val)
            return found

    return Kinds(Part, Entry, IntoEntry)
