"""Every drawing that a spec may name exists, and every drawing that exists may be named."""

from importlib import import_module
from typing import get_args

import hknob_cli.figures as figures
from hknob_cli.specs.report import Draw


def test_specs_and_drawings_agree() -> None:
    assert set(get_args(Draw)) == set(figures.MODULES)
    for module in set(figures.MODULES.values()):
        import_module(f"hknob_cli.figures.{module}")
    assert set(figures.DRAWINGS) == set(figures.MODULES)
