"""The virtual apparatus that an identification's plan describes."""

from dataclasses import replace
from typing import Any

from hknob_cli.apparatus.rig import Rig
from hknob_cli.specs.identification import SysidPlan


def virtual_rig(plan: SysidPlan) -> Rig:
    """The apparatus: as printed, or ideal, but for what is given. Raises `UsageError` for a number out of range."""
    assert plan.virtual is not None
    given: dict[str, Any] = dict(plan.virtual.rig)
    return replace(Rig.ideal() if plan.virtual.ideal else Rig(), **given)
