"""A search for a design that is small enough to evaluate whole: two hands, thirty designs."""

from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from hknob_cli.specs.stage_plans import DesignPlan

DESIGN = """\
kind: design
name: small
base:
  scene:
    knob: {inertia: 19.8 g*cm^2}
    wall: {stiffness: 0.27}
    bias: {torque: 0.001}
  starts: {phases: 2}
people:
  - {table: 1, grip_n: 0.71}
  - {table: 2, grip_n: 2.4}
perceive: {knob_radius: 8.9 mm, extrapolate: true}
choices:
  sample_rate_hz:
    - {value: 500, cost: 0}
    - {value: 1 kHz, cost: 0.5}
  counts_per_rev:
    - {value: 360, cost: 0, label: direct}
    - {value: 1440, cost: 2}
    - {value: 2650, cost: 4, label: geared}
  knob.damping:
    - {value: 0}
    - {value: 5.0e-4, cost: 1}
present: {sample_rate_hz: 1000, counts_per_rev: 2650}
remedies:
  plain wall: {}
  bounded lag:
    cost: 0.25
    change: {scene: {controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.1}}}
  fast:
    cost: 0.75
    change: {grid: {sample_rate_hz: 4000}}
constraints:
  stiffness: {at_least: 0.26}
  touch: {above_present: 0}
"""


def planned(text: str = DESIGN) -> DesignPlan:
    """The plan of a search from text."""
    plan = validate(parse(text, "design.yaml"))
    assert isinstance(plan, DesignPlan)
    return plan
