"""hknob: limit cycles of a haptic knob held against a virtual wall, proven and measured."""

__version__ = "0.1.0"
__all__ = ["Results", "dfa", "load", "predict", "run", "sweep", "sysid"]


def __getattr__(name: str) -> object:
    """The public face (`hknob_cli.api`), loaded when it is first asked for."""
    if name in __all__:
        from hknob_cli import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
