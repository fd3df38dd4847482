"""What may be drawn and computed on a page, as a reference text: every drawing and check with its options."""

from collections.abc import Callable, Iterator
from inspect import Parameter, cleandoc, signature
from typing import Any

from hknob_cli.figures import drawing_of
from hknob_cli.page.claims.checks import known
from hknob_cli.specs.drawings import MODULES

_HEAD = """\
# What a page can draw and compute

A report's spec names drawings (`draw:`) and checks (`check:`, in sentences, captions and ledgers of claims), with their
options under `with:`. This page is made from the program itself (`make schemas`); `data/claims.yaml` and
`experiments/dissertation_report.yaml` have an example of nearly all of them.

```yaml
figures:
  - id: fig-size                                   # its anchor, and the name of figures/fig-size.svg
    draw: grid_map
    of: my-knob                                    # a result by its name in results:, or several
    with: {column: p2p_rad}
    title: Peak to peak
    caption: "At most {most} mrad."                # numbers come from checks
    values:
      most:
        check: cell_statistic
        with: {result: my-knob, column: p2p_rad, statistic: largest}
        scale: 1000
        format: .2f
```

A ledger of claims (`claims: FILE`, `hknob schema claims`) lists what a text says, and judges it:

```yaml
text: the data sheet
claims:
  - id: below-a-milliradian
    place: page 3
    says: the knob never buzzes by more than 1 mrad
    check: cell_statistic
    with: {result: my-knob, column: p2p_rad, statistic: largest}
    unit: rad
    holds: {at_most: 0.001}                        # reproduced; near: differs; neither: contradicted
    because: the sheet says never
```
"""


def reference() -> str:
    """The text, in Markdown."""
    parts = [_HEAD, "## Drawings\n", *_entries({name: drawing_of(name) for name in MODULES}, before=2)]
    parts += ["## Checks\n", *_entries(known(), before=1)]
    return "\n".join(parts)


def _entries(functions: dict[str, Callable[..., Any]], *, before: int) -> Iterator[str]:
    for name, function in sorted(functions.items()):
        options = ", ".join(map(_option, list(signature(function).parameters.values())[before:]))
        yield f"### `{name}`\n\n{cleandoc(function.__doc__ or '')}\n\nOptions: {options or 'none'}\n"


def _option(parameter: Parameter) -> str:
    needed = parameter.default is Parameter.empty
    return f"`{parameter.name}` (needed)" if needed else f"`{parameter.name}: {_yaml(parameter.default)}`"


def _yaml(value: Any) -> str:
    words = {None: "null", True: "true", False: "false"}
    return words[value] if value is None or isinstance(value, bool) else str(value)
