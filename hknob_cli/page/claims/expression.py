"""Arithmetic as text, evaluated safely: numbers, names, + - * / **, and a few functions; nothing else is reachable."""

import ast
import math
import operator
from collections.abc import Callable, Mapping

_TWO: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
}
_ONE: dict[type[ast.unaryop], Callable[[float], float]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "abs": abs,
    "min": min,
    "max": max,
    "floor": math.floor,
}
_CONSTANTS = {"pi": math.pi}


def evaluate(expression: str, names: Mapping[str, float] | None = None) -> float:
    """Value of an arithmetic expression; ``names`` are bound beside ``pi``.

    Raises `TypeError` for anything that is not such arithmetic, for an unknown name, and where there is no value.
    """
    known = {**_CONSTANTS, **(names or {})}

    def value(node: ast.expr) -> float:
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return float(number)
            case ast.Name(id=name) if name in known:
                return known[name]
            case ast.Name(id=name):
                raise TypeError(f"unknown name '{name}' in '{expression}'; known: {', '.join(known)}")
            case ast.BinOp(left=left, op=sign, right=right) if type(sign) in _TWO:
                return _TWO[type(sign)](value(left), value(right))
            case ast.UnaryOp(op=sign, operand=inner) if type(sign) in _ONE:
                return _ONE[type(sign)](value(inner))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in _FUNCTIONS:
                return float(_FUNCTIONS[name](*map(value, arguments)))
        raise TypeError(f"not arithmetic: '{expression}'")

    try:
        found = value(ast.parse(expression.strip(), mode="eval").body)
    except (SyntaxError, ArithmeticError, ValueError, RecursionError, MemoryError) as error:
        raise TypeError(f"no value of '{expression}': {error}") from None
    if not math.isfinite(found):
        raise TypeError(f"no value of '{expression}': it is not finite")
    return found
