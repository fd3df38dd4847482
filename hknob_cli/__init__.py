"""hknob: limit cycles of a haptic knob held against a virtual wall, proven and measured."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hknob_cli.api import Results, Scene, design, dfa, load, predict, remedies, run, sweep, sysid

__version__ = "0.1.0"
__all__ = ["Results", "Scene", "design", "dfa", "load", "predict", "remedies", "run", "sweep", "sysid"]


def __getattr__(name: str) -> object:
    """The public face (`hknob_cli.api`), loaded when it is first asked for."""
    if name in __all__:
        from hknob_cli import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
