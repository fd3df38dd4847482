"""Studies of the estimators as a stage: their bias by its cause, and the finger that hides behind its pad."""

from collections.abc import Callable, Mapping, Sequence

import pyarrow as pa

from hknob_cli.apparatus.people import mean_hand
from hknob_cli.identify.studies import NUISANCES, UNITS, bias_study, hidden_inertia
from hknob_cli.printed.tables import apparatus_inertia
from hknob_cli.results.arrays import build_table
from hknob_cli.specs.identification import BiasPlan, HiddenPlan
from hknob_cli.stages.sysid import columns
from hknob_cli.stages.sysid.columns import PARAMETERS

Progress = Callable[[int, int], None]


def levels_of(plan: BiasPlan) -> Mapping[str, Sequence[float]]:
    """Levels of each nuisance by its name: those asked for, or all there are."""
    return plan.nuisances or NUISANCES


def study_bias(plan: BiasPlan, progress: Progress = lambda _done, _total: None) -> pa.Table:
    """Bias and spread of every estimator and parameter at each level of each nuisance."""
    found = bias_study(
        plan.repeats,
        table=plan.table,
        grips_n=plan.grips_n,
        nuisances=levels_of(plan),
        seed=plan.seed,
        progress=progress,
    )
    units = {name: unit for name, (_, unit, _) in PARAMETERS.items()}
    rows = [{**one._asdict(), "level_unit": UNITS[one.nuisance], "unit": units[one.parameter]} for one in found]
    return build_table(columns.BIAS, rows)


def study_hidden(plan: HiddenPlan, progress: Progress = lambda _done, _total: None) -> pa.Table:
    """Second-order fits of the fourth-order hand, over the ratio of finger to pad."""
    hand = mean_hand(plan.table, plan.grip_n)
    knob = apparatus_inertia(plan.table)
    found = hidden_inertia(
        hand.damping,
        hand.stiffness,
        inertia=knob,
        finger_inertia=plan.finger_inertia,
        ratios=plan.ratios,
        progress=progress,
    )
    rows = [
        {
            "ratio": one.ratio,
            "estimator": one.estimator,
            "inertia_kg_m2": one.inertia,
            "damping_nm_s_per_rad": one.damping,
            "stiffness_nm_per_rad": one.stiffness,
            "vaf": one.vaf,
            "knob_inertia_kg_m2": knob,
            "finger_inertia_kg_m2": plan.finger_inertia,
        }
        for one in found
    ]
    return build_table(columns.HIDDEN, rows)
