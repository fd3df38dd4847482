"""Figures by name: each draws one kind of picture from finished results.

A drawing takes the `ResultSet`, the name ``of`` the result (or a list of names), and options of its own as keywords; it
returns a matplotlib Figure, made by `theme.figure`, without a title: the page has titles and captions. It raises
`MissingError` where a result lacks what it needs. A parameter may be a named tuple of options that belong together. A
page gives its fields, each by its name.

- a figure a name, from finished results: the page renders it as SVG, `--plot` as PNG
- entered in `specs/drawings`
- `theme` the style, `numbers` how values are written, `defaults` which figures a result has, `sheet` figures as one
  PNG, `plot` those of each stage
- `maps` over two axes, whose cells and axes' names `grid` arranges
- `*_picture` what only `--plot` draws yet
"""

from collections.abc import Callable
from functools import wraps
from importlib import import_module
from inspect import Parameter, cleandoc, signature
from typing import TYPE_CHECKING, Any

from hknob_cli.figures.theme import styled
from hknob_cli.results.result_set import ResultSet
from hknob_cli.specs.drawings import MODULES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Drawing = Callable[..., "Figure"]

DRAWINGS: dict[str, Drawing] = {}


def drawing(function: Drawing) -> Drawing:
    """Register a drawing under its name."""
    DRAWINGS[function.__name__] = styled(taking_fields(function))
    return DRAWINGS[function.__name__]


def taking_fields(function: Drawing) -> Drawing:
    """The drawing with an option for each field of its named tuples. Its signature and docstring say so, too."""
    given = signature(function)
    groups = {one.name: one.annotation for one in given.parameters.values() if hasattr(one.annotation, "_fields")}

    @wraps(function)
    def packed(*args: Any, **options: Any) -> "Figure":
        packs = {
            name: group(**{field: options.pop(field) for field in group._fields if field in options})
            for name, group in groups.items()
        }
        return function(*args, **options, **packs)

    options: list[Parameter] = []
    for one in given.parameters.values():
        options += _fields(groups[one.name]) if one.name in groups else [one]
    vars(packed)["__signature__"] = given.replace(parameters=options)
    packed.__doc__ = "\n\n".join(cleandoc(one.__doc__ or "") for one in (function, *groups.values()))
    return packed


def _fields(group: Any) -> list[Parameter]:
    """An option for each field of a named tuple."""
    return [one.replace(kind=Parameter.KEYWORD_ONLY) for one in signature(group).parameters.values()]


def drawing_of(name: str) -> Drawing:
    """The drawing of a name, its module loaded."""
    if name not in DRAWINGS:
        import_module(f"{__name__}.{MODULES[name]}")
    return DRAWINGS[name]


def draw(name: str, evidence: ResultSet, of: Any, options: dict[str, Any]) -> "Figure":
    """Draw a figure. Raises `MissingError`, and `TypeError` for options it does not take."""
    return drawing_of(name)(evidence, of, **options)
