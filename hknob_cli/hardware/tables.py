"""The tables of a campaign: every sample, every trial measured as Chapter 8 does, or every pulse; and its clock."""

import hashlib
import math
from typing import Any

import numpy as np
import pyarrow as pa

from hknob_cli.errors import MISSHAPEN
from hknob_cli.hardware.order import Trial, period_ns, settings_of
from hknob_cli.hardware.person import grip_of, squeezer, squeezing_hand
from hknob_cli.hardware.sample_clock import audit
from hknob_cli.hardware.trial_file import Recorded
from hknob_cli.hardware.trial_phases import Ended
from hknob_cli.hardware.trial_wall import words_of
from hknob_cli.hardware.wire.codes import pack_act, pieces_of
from hknob_cli.recordings.files import first_line
from hknob_cli.recordings.measured_cycle import TrialMeasures, measure_trial
from hknob_cli.recordings.spectrum import pitch_hz, torque_rises_hz
from hknob_cli.results.arrays import build_table
from hknob_cli.results.campaign_files import (
    CONTROLLED,
    CONVERTED,
    PULSE_TIMING,
    PULSE_TRIALS,
    SHAPED,
    TIMING,
    TRIALS,
    TRIED,
    TRUTH,
)
from hknob_cli.specs.campaign import VIRTUAL, Course, HwRunPlan
from hknob_cli.specs.pulses import PulsePlan

_DIGITS = 16  # of a digest


def campaign_tables(done: list[Recorded], plan: HwRunPlan) -> tuple[pa.Table, pa.Table, pa.Table]:
    """Samples, trials and timing of finished trials, in the order they were run.

    A trial that cannot be measured has a row without measures, which says why.
    """
    samples = pa.concat_tables([one.table for one in done]).combine_chunks()
    tried = TRIED if plan.has_remedies else ()
    controlled = CONTROLLED if tried or plan.first.controller else ()
    rows = [{**_row(one, plan.course), **(_acting(plan, one.trial) if controlled else {})} for one in done]
    shaped = SHAPED if plan.effects else ()
    if shaped:
        rows = [{**row, **_shaping(plan, one.trial)} for row, one in zip(rows, done, strict=True)]
    converted = CONVERTED if plan.converts else ()
    if converted:
        rows = [{**row, **_converting(plan, one.trial)} for row, one in zip(rows, done, strict=True)]
    trials = build_table((*TRIALS, *controlled, *shaped, *converted, *tried), rows)
    return samples, trials, build_table(TIMING, [timing_row(one, place_of(one)) for one in done])


def _acting(plan: HwRunPlan, trial: Trial) -> dict[str, Any]:
    """What acted in a trial: values of `CONTROLLED` and `TRIED`."""
    acts, control = plan.tried(trial.remedy), settings_of(plan, trial).control
    return {
        "controller": acts.controller.words if acts.controller else "",
        "remedy": acts.name,
        "wall_stiffness": acts.wall.stiffness,
        "wall_damping": acts.wall.damping,
        "control_digest": _digest(pack_act(control)) if control else "",
    }


def _shaping(plan: HwRunPlan, trial: Trial) -> dict[str, Any]:
    """Which torque over the angle acted in a trial: values of `SHAPED`."""
    over = settings_of(plan, trial).over_angle
    assert over is not None
    table, pieces = pieces_of(over)
    return {"over_angle_digest": _digest(b"".join([pack_act(table), *map(pack_act, pieces)]))}


def _converting(plan: HwRunPlan, trial: Trial) -> dict[str, Any]:
    """Which converters acted in a trial: values of `CONVERTED`."""
    told = settings_of(plan, trial).converters
    if told is None:
        return {"converters": "", "converters_digest": ""}
    return {"converters": words_of(told), "converters_digest": _digest(pack_act(told))}


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:_DIGITS]


def _row(one: Recorded, course: Course) -> dict[str, Any]:
    try:
        return trial_row(one, course)
    except MISSHAPEN as error:
        return _unmeasured(one, f"cannot be measured: {first_line(error)}")


def trial_row(one: Recorded, course: Course) -> dict[str, Any]:
    """One trial, measured."""
    column = {name: one.table[name].to_numpy(zero_copy_only=False) for name in one.table.column_names}
    measured = measure_trial(
        column["time_s"],
        column["angle_rad"],
        column["torque_nm"],
        column["grip_n"],
        column["running"],
        step_rad=2.0 * math.pi / one.native_counts,
        least_s=course.buzz[0],
        settle_s=course.settle,
    )
    torque_hz = _torque_hz(column, measured)
    return {
        **place_of(one),
        "sustained": measured.sustained,
        "p2p_rad": measured.p2p_rad,
        "rms_rad": measured.rms_rad,
        "frequency_hz": pitch_hz(
            p2p_rad=measured.p2p_rad,
            cycle_hz=measured.cycle_hz,
            torque_hz=torque_hz,
            native_counts=one.native_counts,
            counts_per_rev=one.trial.counts_per_rev,
        ),
        "spectral_hz": measured.spectral_hz,
        "cycle_hz": measured.cycle_hz,
        "torque_hz": torque_hz,
        "grip_mean_n": measured.grip_mean_n if course.grip else None,
        "grip_std_n": measured.grip_std_n if course.grip else None,
        "grip_zero_n": one.zero_n if course.grip else None,
        "wall_torque_nm": measured.wall_torque_nm,
        "settled_s": _settled_s(one),
        "steady_s": measured.steady_s,
        "steady_first": measured.steady[0],
        "steady_last": measured.steady[1],
        **ending_of(one, "; ".join(_doubts(one, measured, course))),
    }


def _unmeasured(one: Recorded, why: str) -> dict[str, Any]:
    """The row of a trial without its measures."""
    return {
        **dict.fromkeys(column.name for column in TRIALS),
        **place_of(one),
        "sustained": False,
        **ending_of(one, why),
    }


def place_of(one: Recorded) -> dict[str, Any]:
    """Where a trial is in the campaign."""
    trial = one.trial
    return {
        "order": trial.number,
        "block": trial.block,
        "sample_rate_hz": trial.sample_rate_hz,
        "counts_per_rev": trial.counts_per_rev,
    }


def ending_of(one: Recorded, fault: str) -> dict[str, Any]:
    """How a trial ended, what was recorded of it, on what, and what is doubtful about it."""
    return {
        "ended": one.ended,
        "samples": one.table.num_rows,
        "gaps": one.gaps,
        "overruns": one.overruns,
        "fault": fault,
        "device": one.device,
        "native_counts": one.native_counts,
    }


def _torque_hz(column: dict[str, Any], measured: TrialMeasures) -> float:
    """Rises of the torque per second in the steady part; 0 at rest."""
    part = slice(measured.steady[0], measured.steady[1] + 1)
    return torque_rises_hz(column["time_s"][part], column["torque_nm"][part]) if measured.sustained else 0.0


def _settled_s(one: Recorded) -> float | None:
    """Time from the start until the grip counted as held."""
    if one.settled_sample is None:
        return None
    running = one.table["running"].to_numpy(zero_copy_only=False)
    start = int(one.table["sample"].to_numpy()[int(np.argmax(running))])
    return (one.settled_sample - start) / one.trial.sample_rate_hz


def _doubts(one: Recorded, measured: TrialMeasures, course: Course) -> list[str]:
    """What is doubtful about a trial, in words."""
    found = []
    if one.settled_sample is None:
        found.append("the grip was never held in its band" if course.grip else "it ended before it had settled")
    elif one.ended == Ended.LONGEST:
        found.append("neither buzz nor rest lasted until it was too long")
    if measured.sustained and measured.p2p_rad == 0.0:
        found.append("the buzz is smaller than the device's own encoder can tell")
    if one.ended == Ended.OVER:
        found.append("the recording that was replayed was over before it had ended")
    return found + missing(one)


def missing(one: Recorded) -> list[str]:
    """Samples that are missing, and the loop's late ones, in words; empty if there are none."""
    found = [f"{one.gaps} samples are missing"] if one.gaps else []
    return found + ([f"the loop was late {one.overruns} times"] if one.overruns else [])


def timing_row(one: Recorded, place: dict[str, Any]) -> dict[str, Any]:
    """One trial's sample clock, audited; ``place``: where the trial is in its campaign."""
    number, time_us = (one.table[name].to_numpy() for name in ("sample", "device_time_us"))
    return {
        **place,
        **audit(number, time_us, period_ns=period_ns(one.trial.sample_rate_hz), overruns=one.overruns)._asdict(),
        "host_drift": one.drift,
        "host_drift_uncertainty": one.drift_uncertainty,
    }


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
    rows = [{**nothing, **_pulse_row(one, plan), **(_truth(one, plan) if simulated else {})} for one in done]
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


def _pulse_row(one: Recorded, plan: PulsePlan) -> dict[str, Any]:
    settings = settings_of(plan, one.trial)
    assert settings.pulse is not None
    fired = one.settled_sample is not None
    return {
        **_place(one),
        "fired": fired,
        "pulse_torque_nm": settings.pulse.torque_nm,
        **(_pulse(one, settings.interval_s) if fired else {}),
        "grip_zero_n": one.zero_n,
        **ending_of(one, "; ".join(_pulse_doubts(one))),
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
    return dict(zip((column.name for column in TRUTH), squeezing_hand(squeeze, grip), strict=True))


def _pulse_doubts(one: Recorded) -> list[str]:
    """What is doubtful about a trial, in words."""
    return [text for ended, text in _DOUBTS.items() if one.ended == ended.value] + missing(one)
