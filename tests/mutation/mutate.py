"""Small changes of a function's source, one at a time: what a slip of the hand would make of a proof.

Changed are comparisons (`<` to `<=` and to `>=`), signs, products and quotients, coefficients (twice, half; a whole
number by one), conditions (a part left out, `and` for `or`), `min` for `max`; `abs`, `sqrt` and terms are left out.
Indices, lengths of loops, and plain numbers in a returned tuple are left as they are: they are no part of an argument.
"""

import ast
import copy
from collections.abc import Callable, Container, Iterator
from pathlib import Path
from types import CodeType
from typing import Any, NamedTuple

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Div,
    ast.Mod: ast.Mult,
}


class Mutant(NamedTuple):
    """One change: of which function of which file (None: of a constant of the file), where, and what."""

    path: Path
    function: str | None
    line: int
    text: str  # of the line
    change: str  # "before => after"
    tree: ast.stmt  # the function, or the assignment, changed
    owner: str  # the class, of a method
    statement: int  # first line of the innermost statement that is changed; 0 of the whole

    def code(self) -> CodeType:
        """Code of the changed function."""
        whole = self._compiled()
        for name in str(self.function).split("."):
            whole = next(one for one in whole.co_consts if isinstance(one, CodeType) and one.co_name == name)
        return whole

    def value(self) -> object:
        """Value of the changed constant."""
        names: dict[str, object] = {}
        exec(self._compiled(), names)
        return names[self.name]

    def _compiled(self) -> CodeType:
        tree = self.tree
        if self.owner:  # in a class of its name, that `super` works
            tree = ast.ClassDef(self.owner, [], [], [tree], [])
        return compile(ast.fix_missing_locations(ast.Module([tree], [])), str(self.path), "exec")

    @property
    def name(self) -> str:
        """Of the function or the constant."""
        if self.function is not None:
            return self.function
        assert isinstance(self.tree, ast.Assign)
        assert isinstance(self.tree.targets[0], ast.Name)
        return self.tree.targets[0].id

    def __str__(self) -> str:
        return f"{self.path.name}:{self.line} {self.name}: {self.change}\n    {self.text}"


def mutants(path: Path, among: Container[str] | None = None) -> Iterator[Mutant]:
    """All changes of a file: of functions, of methods without decorators, and of constants that are floats.

    ``among``: names of functions to which it is confined.
    """
    source = path.read_text()
    lines = source.splitlines()
    for owner, statement in _statements(ast.parse(source)):
        if isinstance(statement, ast.FunctionDef):
            function: str | None = owner + statement.name
            if among is not None and function not in among:
                continue
        elif isinstance(statement, ast.Assign) and _is_number(statement.value):
            function = None
        else:
            continue
        places = list(_places(statement, ()))
        for steps in places:
            for after in changes(_at(statement, steps), steps):
                changed = _changed(statement, steps, after)
                node = _at(statement, steps)
                # A number alone would not tell which it is.
                shown = steps[:-1] if isinstance(node, ast.Constant) and len(steps) > 1 else steps
                before, later = _at(statement, shown), _at(changed, shown)
                if isinstance(before, ast.stmt):
                    before, later = _at(statement, steps), _at(changed, steps)
                change = f"{ast.unparse(before)} => {ast.unparse(later)}"
                text = lines[node.lineno - 1].strip()
                ways = [steps[:k] for k in range(1, len(steps) + 1)]
                inside = [0, *(one.lineno for way in ways if isinstance(one := _at(statement, way), ast.stmt))]
                yield Mutant(path, function, node.lineno, text, change, changed, owner.strip("."), inside[-1])


def noting(path: Path, note: str) -> Iterator[tuple[str, CodeType]]:
    """Of each function of a file that may be changed: its code, in which ``note`` runs before each statement.

    ``note`` has ``{name}``, of the function, and ``{line}``, the first line of the statement, or 0 for the function.
    """
    for owner, statement in _statements(ast.parse(path.read_text())):
        if isinstance(statement, ast.FunctionDef):
            name = owner + statement.name
            _note_statements(statement, note.replace("{name}", name))
            statement.body[:0] = ast.parse(note.format(name=name, line=0)).body
            yield name, Mutant(path, name, 0, "", "", statement, owner.strip("."), 0).code()


def _note_statements(node: ast.AST, note: str) -> None:
    """Put a note before each statement below this one, in place."""
    for _, value in ast.iter_fields(node):
        inner = value if isinstance(value, list) else [value]
        for one in [one for one in inner if isinstance(one, ast.AST)]:
            _note_statements(one, note)
        if isinstance(value, list) and value and isinstance(value[0], ast.stmt):
            value[:] = [new for one in value for new in (*ast.parse(note.format(line=one.lineno)).body, one)]


Steps = tuple[tuple[str, int | None], ...]


def _statements(module: ast.Module) -> Iterator[tuple[str, ast.stmt]]:
    """Those of a file, and the methods of its classes, each with what its name begins with."""
    for statement in module.body:
        yield "", statement
        if isinstance(statement, ast.ClassDef):
            for one in statement.body:
                if isinstance(one, ast.FunctionDef) and not one.decorator_list:
                    yield f"{statement.name}.", one


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, float)


def _at(node: ast.AST, steps: Steps) -> ast.AST:
    for field, index in steps:
        node = getattr(node, field) if index is None else getattr(node, field)[index]
    return node


def _changed(node: Any, steps: Steps, after: ast.AST) -> Any:
    """A copy with one node of it changed; it shares all that is not on the way there."""
    if not steps:
        return after
    (field, index), *rest = steps
    changed, value = copy.copy(node), getattr(node, field)
    if index is not None:
        value, old = list(value), value[index]
        value[index] = _changed(old, tuple(rest), after)
    setattr(changed, field, _changed(value, tuple(rest), after) if index is None else value)
    return changed


def _places(node: ast.AST, steps: Steps) -> Iterator[Steps]:
    """Ways to all nodes that may be changed."""
    if steps:
        yield steps
    for field, value in ast.iter_fields(node):
        if field in ("args", "decorator_list", "targets", "target", "func") and not isinstance(node, ast.Call):
            continue
        if isinstance(node, ast.Subscript) and field == "slice":
            continue
        if isinstance(node, ast.Call) and (field == "func" or _calls(node, "range", "len")):
            continue
        if isinstance(value, ast.AST):
            yield from _places(value, (*steps, (field, None)))
        elif isinstance(value, list):
            fill = isinstance(node, ast.Tuple) and steps[-2:-1] != () and steps[-1][0] == "value"
            for k, one in enumerate(value):
                if isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant):
                    continue  # a docstring
                if fill and isinstance(one.operand if isinstance(one, ast.UnaryOp) else one, ast.Constant):
                    continue
                if isinstance(one, ast.AST):
                    yield from _places(one, (*steps, (field, k)))


def _calls(node: ast.AST, *names: str) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in names


def changes(node: ast.AST, steps: Steps) -> Iterator[ast.AST]:
    """What may stand in a node's place."""
    for kind, change in CHANGES.items():
        if isinstance(node, kind):
            yield from change(node, steps)


def _compare(node: ast.Compare, steps: Steps) -> Iterator[ast.AST]:
    for k, op in enumerate(node.ops):
        for other in COMPARISONS.get(type(op), ()):
            yield ast.Compare(node.left, [*node.ops[:k], other(), *node.ops[k + 1 :]], node.comparators)


def _binary(node: ast.BinOp, steps: Steps) -> Iterator[ast.AST]:
    if type(node.op) in OPERATORS:
        yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)
    if isinstance(node.op, ast.Add | ast.Sub):
        yield node.left
    if isinstance(node.op, ast.Add):
        yield node.right


def _boolean(node: ast.BoolOp, steps: Steps) -> Iterator[ast.AST]:
    yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    for k in range(len(node.values)):
        rest = [*node.values[:k], *node.values[k + 1 :]]
        yield rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)


def _unary(node: ast.UnaryOp, steps: Steps) -> Iterator[ast.AST]:
    if isinstance(node.op, ast.USub | ast.Not):
        yield node.operand


def _choice(node: ast.IfExp, steps: Steps) -> Iterator[ast.AST]:
    yield node.body
    yield node.orelse


def _number(node: ast.Constant, steps: Steps) -> Iterator[ast.AST]:
    value = node.value
    if isinstance(value, bool):
        yield ast.Constant(not value)
    elif isinstance(value, int):
        yield from (ast.Constant(value + step) for step in (-1, 1))
    elif isinstance(value, float) and value == 0.0:
        yield ast.Constant(1.0)
        if steps[-1][0] == "comparators":
            yield ast.Constant(-1.0)
    elif isinstance(value, float):
        yield from (ast.Constant(value * by) for by in (0.5, 2.0))


def _call(node: ast.Call, steps: Steps) -> Iterator[ast.AST]:
    if _calls(node, "abs", "sqrt"):
        yield node.args[0]
    if _calls(node, "min", "max"):
        assert isinstance(node.func, ast.Name)
        yield ast.Call(ast.Name("max" if node.func.id == "min" else "min", ast.Load()), node.args, [])
        for k in range(len(node.args)):
            rest = [*node.args[:k], *node.args[k + 1 :]]
            yield rest[0] if len(rest) == 1 else ast.Call(node.func, rest, [])


def _augmented(node: ast.AugAssign, steps: Steps) -> Iterator[ast.AST]:
    if type(node.op) in OPERATORS:
        yield ast.AugAssign(node.target, OPERATORS[type(node.op)](), node.value)
        yield ast.Pass()


CHANGES: dict[type, Callable[..., Iterator[ast.AST]]] = {
    ast.Compare: _compare,
    ast.BinOp: _binary,
    ast.BoolOp: _boolean,
    ast.UnaryOp: _unary,
    ast.IfExp: _choice,
    ast.Constant: _number,
    ast.Call: _call,
    ast.AugAssign: _augmented,
}
