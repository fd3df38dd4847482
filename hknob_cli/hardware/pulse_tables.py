"""The tables of a campaign of pulses: samples about each pulse, trials, and their sample clock."""

from typing import Any

import numpy as np
import pyarrow as pa

from hknob_cli.hardware.order import settings_of
from hknob_cli.hardware.pulse_person import grip_of, hand_at, squeezer
from hknob_cli.hardware.tables import ending_of, missing, timing_row
from hknob_cli.hardware.trial_file import Recorded
from hknob_cli.hardware.trial_phases import Ended
from hknob_cli.results.arrays import build_table
from hknob_cli.results.pulse_files import PULSE_TIMING, PULSE_TRIALS, TRUTH
from hknob_cli.specs.campaign import VIRTUAL
from hknob_cli.specs.pulses import PulsePlan

_DOUBTS = {
    Ended.UNFIRED: "no pulse: the grip did not come to its target, or was never below the release level",
    Ended.GRIPPING: "the hand did not relax after the pulse",
    Ended.OPERATOR: "the operator ended it",
    Ended.OVER: "the samples were over before it had ended",
}


def pulse_tables(done: list[Recorded], plan: PulsePlan) -> tuple[pa.Table, pa.Table, pa.Table]:
    """Samples, trials and timing of finished trials, in the order they were run."""
    samples = pa.concat_tables([one.table for one in done]).combine_chunks()
    simulated = plan.device.driver == VIRTUAL or plan.device.target is not None
    columns = (*PULSE_TRIALS, *(TRUTH if simulated else ()))
    nothing: dict[str, Any] = dict.fromkeys(column.name for column in columns)
    rows = [{**nothing, **_row(one, plan), **(_truth(one, plan) if simulated else {})} for one in done]
    trials = build_table(columns, rows)
    return samples, trials, build_table(PULSE_TIMING, [timing_row(one, _place(one)) for one in done])


def _place(one: Recorded) -> dict[str, Any]:
    trial = one.trial
    return {
        "order": trial.number,
        "block": trial.block,
        "grip_target_n": trial.grip_target_n,
        "sample_rate_hz": trial.sample_rate_hz,
    }


def _row(one: Recorded, plan: PulsePlan) -> dict[str, Any]:
    settings = settings_of(plan, one.trial)
    assert settings.pulse is not None
    fired = one.settled_sample is not None
    return {
        **_place(one),
        "fired": fired,
        "pulse_torque_nm": settings.pulse.torque_nm,
        **(_pulse(one, settings.interval_s) if fired else {}),
        "grip_zero_n": one.zero_n,
        **ending_of(one, "; ".join(_doubts(one))),
    }


def _pulse(one: Recorded, interval_s: float) -> dict[str, Any]:
    """What the samples say of a pulse that came."""
    column = {name: one.table[name].to_numpy() for name in ("sample", "torque_nm", "angle_rad", "grip_n")}
    at = int(np.searchsorted(column["sample"], one.settled_sample or 0))
    pushed = column["torque_nm"] != 0.0
    return {
        "pulse_width_s": float(pushed.sum()) * interval_s,
        "fired_s": _fired_s(one),
        "grip_n": float(column["grip_n"][at]),
        "grip_pulse_n": float(column["grip_n"][pushed].mean()),
        "peak_rad": float(np.abs(column["angle_rad"][at:] - column["angle_rad"][: at + 1].mean()).max()),
    }


def _fired_s(one: Recorded) -> float:
    """From the start to the pulse, ticks that were left out aside."""
    return ((one.settled_sample or 0) - (one.started_sample or 0)) / one.trial.sample_rate_hz


def _truth(one: Recorded, plan: PulsePlan) -> dict[str, Any]:
    """The simulated knob and hand at the pulse."""
    squeeze = squeezer(plan, one.trial).squeeze
    if one.settled_sample is None or not squeeze:
        return {}
    grip = float(grip_of(squeeze, np.array([_fired_s(one)]), None)[0])
    return dict(zip((column.name for column in TRUTH), hand_at(squeeze, grip), strict=True))


def _doubts(one: Recorded) -> list[str]:
    """What is doubtful about a trial, in words."""
    return [text for ended, text in _DOUBTS.items() if one.ended == ended.value] + missing(one)
