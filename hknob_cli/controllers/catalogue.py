"""Every controller by the name that a spec gives it."""

from importlib import import_module

from hknob_cli.controllers.controller import ControlLaw
from hknob_cli.specs.controller_plan import KINDS, Controller


def make_control_law(plan: Controller) -> ControlLaw:
    """The controller of a scene; only its own file is loaded."""
    module, _, name = KINDS[plan.kind].law.partition(":")
    law: ControlLaw = getattr(import_module(f"hknob_cli.controllers.{module}"), name).of(plan)
    return law
