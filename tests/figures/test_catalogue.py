"""Every figure that a spec may name exists, and every figure that exists may be named."""

from importlib import import_module

import hknob_cli.figures as figures
from hknob_cli.specs.drawings import MODULES
from tests.conftest import ROOT


def test_specs_and_figures_agree() -> None:
    for module in set(MODULES.values()):
        import_module(f"hknob_cli.figures.{module}")
    assert set(figures.DRAWINGS) == set(MODULES)
    assert list(MODULES) == sorted(MODULES)
    registering = {
        path.stem for path in (ROOT / "hknob_cli/figures").glob("*.py") if "\n@drawing\n" in path.read_text()
    }
    assert registering == set(MODULES.values())
