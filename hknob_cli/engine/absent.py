"""What a scene does not have, left out before it is compiled: conditions that the types of arguments decide.

A part that a scene lacks is None: cogging, a curve, a clock that jitters, a law. Numba leaves out what follows
``if law is None`` where the law is None, and only there. Where there is a law it compiles what would be done without
one, and all that this calls. It compiles, too, what follows ``if has_cogs(body.cogs)`` without cogging. Here such
conditions become the constants that they are, and numba leaves out what they exclude.
"""

import operator
from functools import cache
from typing import Any

HAS = ("has_cogs", "has_curve", "is_there", "jitters")  # functions of one part, false of None


def kind_of(ir: Any, variable: Any, args: Any) -> Any:
    """Type of an argument in numba's code, or of a field of one; None where it is not known yet."""
    from numba.core.ir import Arg, Expr
    from numba.core.ir_utils import get_definition, guard
    from numba.core.types import BaseNamedTuple

    value = guard(get_definition, ir, variable)
    if isinstance(value, Arg):
        return args[value.index]
    if not isinstance(value, Expr):
        return None
    if value.op == "getattr":
        whole = kind_of(ir, value.value, args)
        fields = getattr(whole, "fields", ()) if isinstance(whole, BaseNamedTuple) else ()
        if value.attr in fields:
            return whole.types[fields.index(value.attr)]
    if value.op == "static_getitem":  # of several names that are assigned at once
        listed = guard(get_definition, ir, value.value)
        if isinstance(listed, Expr) and listed.op == "exhaust_iter":
            listed = guard(get_definition, ir, listed.value)
        if isinstance(listed, Expr) and listed.op == "build_tuple":
            return kind_of(ir, listed.items[value.index], args)
    return None


def answer(ir: Any, asked: Any, args: Any) -> bool | None:
    """What an expression in numba's code is by the types of arguments; None where they do not decide it."""
    from numba.core.ir import Const
    from numba.core.ir_utils import get_definition, guard
    from numba.core.registry import CPUDispatcher
    from numba.core.types import NoneType, Omitted, Optional

    if asked.op == "call" and len(asked.args) == 1:
        called = getattr(guard(get_definition, ir, asked.func), "value", None)
        name = called.py_func.__name__ if isinstance(called, CPUDispatcher) else ""
        return False if name in HAS and isinstance(kind_of(ir, asked.args[0], args), NoneType) else None
    if asked.op == "binop" and asked.fn in (operator.is_, operator.is_not):
        kind, other = kind_of(ir, asked.lhs, args), guard(get_definition, ir, asked.rhs)
        if kind is None or isinstance(kind, Omitted | Optional) or not isinstance(other, Const):
            return None
        if other.value is None:
            return isinstance(kind, NoneType) == (asked.fn is operator.is_)
    return None


@cache
def deciding() -> Any:
    """The step of numba's compiler, which is loaded here, that does so. It belongs before `DeadBranchPrune`."""
    from numba.core.compiler_machinery import FunctionPass, register_pass
    from numba.core.consts import ConstantInference
    from numba.core.ir import Assign, Const, Expr

    @register_pass(mutates_CFG=False, analysis_only=False)
    class Deciding(FunctionPass):
        """Writes constants in place of conditions that types decide."""

        _name = "deciding"

        def __init__(self) -> None:
            super().__init__()  # abstract in numba

        def run_pass(self, state: Any) -> bool:
            """Whether anything has changed."""
            ir, changed = state.func_ir, False
            for block in ir.blocks.values():
                for line in block.body:
                    if not (isinstance(line, Assign) and isinstance(line.value, Expr)):
                        continue
                    asked = line.value
                    found = answer(ir, asked, state.args)
                    if found is not None:
                        line.value, changed = Const(found, loc=line.loc), True
                        # A name may be given other values elsewhere.
                        known = ir._definitions[line.target.name]
                        known[:] = [line.value if one is asked else one for one in known]
            if changed:
                ir._consts = ConstantInference(ir)
            return changed

    return Deciding
