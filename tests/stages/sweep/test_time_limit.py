"""limits.seconds_per_cell: what it ends, in every engine, what it leaves alone, and what the tables say."""

import time
from math import inf
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine import alarm
from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import Attractor, Engine, NeedsCompilerError, Patience
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.general.slide_many import slide_many
from hknob_cli.engine.outcome import WORDS, Outcome, Reason
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import loaded

STIFF = {  # rings 57 times between two samples: thousands of steps each
    "knob": {"inertia": 1.9e-6, "coulomb_torque": 5.6e-4},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 7.0e4},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
    "actuator": {"time_constant": 1.0e-5},
}
TIRELESS = Patience(samples=10**9)

SPEC = """
kind: sweep
name: limited
scene:
  knob: {inertia: 1.9e-6}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {torque: 0.001}
grid: {sample_rate_hz: [1000], counts_per_rev: [256, 1024]}
starts: {phases: 16}
"""


def stiff() -> GeneralKnob:
    return sample_general(SceneSpec.model_validate(STIFF).plain(), sample_rate_hz=1000.0, counts_per_rev=1024)


def search(engine: GeneralEngine, seconds: float | None, phases: int = 3) -> tuple[Attractor, ...]:
    one = stiff()
    return engine.search(
        one.body,
        one.wall,
        one.start(0.02, 0.0),
        rate=one.rate,
        phases=phases,
        delay_line=one.delay_line,
        max_samples=None,
        seconds=seconds,
    ).attractors


def test_a_stiff_hand_behind_a_lag_ends_with_its_time() -> None:
    """One of its trials takes minutes in the interpreter: the limit is heard in the middle of it."""
    begin = time.process_time()
    found = search(GeneralEngine(patience=TIRELESS), 0.5)
    assert time.process_time() - begin < 30.0
    assert found == (Attractor(outcome=Outcome.UNDECIDED, reason=Reason.TIME_LIMIT, trials=3),)
    assert "limits.seconds_per_cell" in WORDS[Reason.TIME_LIMIT]


def test_the_interpreter_hands_over_what_takes_it_too_long() -> None:
    impatient = GeneralEngine(patience=Patience(samples=10**9, seconds=0.3))
    with pytest.raises(NeedsCompilerError):
        search(impatient, None)
    with pytest.raises(NeedsCompilerError):
        search(impatient, 1e6)
    assert search(impatient, 0.1)[0].reason is Reason.TIME_LIMIT


def test_a_slide_stops_where_its_body_is_told_to() -> None:
    one = stiff()
    z = one.start(0.02, 0.0)
    one.body.halt[0] = 1.0
    assert slide_many(z, 0.0, -1, 1.0, one.body, [0.0] * 6) == (0.0, False, 0)
    assert z == one.start(0.02, 0.0)


def test_trials_that_are_done_before_the_time_count() -> None:
    """The plain loop, a trial at a time; a limit that is not reached changes nothing."""
    scene = {key: STIFF[key] for key in ("wall", "bias")} | {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    }
    knob = sample_knob(SceneSpec.model_validate(scene).plain(), sample_rate_hz=1000.0, counts_per_rev=1024)

    def found(seconds: float | None, phases: int = 16) -> tuple[Attractor, ...]:
        return (
            Engine()
            .search(
                knob.loop,
                x=knob.position(0.02),
                v=0.0,
                phases=phases,
                delay_line=knob.delay_line,
                max_samples=None,
                seconds=seconds,
            )
            .attractors
        )

    assert found(1e5) == found(None)
    late = found(0.02, phases=100_000)
    assert sum(one.trials for one in late) == 100_000
    assert {one.reason for one in late if one.outcome is Outcome.UNDECIDED} == {Reason.TIME_LIMIT}
    assert sum(one.trials for one in late if one.outcome is Outcome.CYCLE) > 0


@pytest.mark.parametrize("change", ["", "knob: {inertia: 1.9e-6, coulomb_torque: 2.0e-4}", "controller"])
def test_a_limit_that_is_not_reached_changes_no_byte(change: str) -> None:
    text = SPEC
    if change.startswith("knob"):
        text = text.replace("knob: {inertia: 1.9e-6}", change)
    if change == "controller":
        text = text.replace("  wall:", "  controller: {kind: bounded_lag, keep: 0.15}\n  wall:")
    free, limited = (
        SweepStage(loaded(spec), jobs=1).run() for spec in (text, text + "limits: {seconds_per_cell: 10000}\n")
    )
    assert free.cells.equals(limited.cells)
    assert free.orbits.equals(limited.orbits)


def reasons(text: str) -> set[tuple[str, str]]:
    rows: list[dict[str, Any]] = SweepStage(loaded(text), jobs=1).run().orbits.to_pylist()
    return {(row["outcome"], row["reason"]) for row in rows}


def test_a_controllers_trials_end_with_their_time() -> None:
    """Trials, of which some are done before the limit is heard; and sets of starts, which are none of them done."""
    text = SPEC.replace("  wall:", "  controller: {kind: bounded_lag, keep: 0.15}\n  wall:")
    late = ("undecided", WORDS[Reason.TIME_LIMIT])
    assert late in reasons(
        text.replace("phases: 16", "angle: 0.02, phases: 4096") + "limits: {seconds_per_cell: 0.02}\n"
    )
    sets = text.replace("phases: 16", "angle: 0.02")
    assert reasons(sets + "limits: {seconds_per_cell: 1.0e-6}\n") == {late}


def test_bounces_end_with_their_time() -> None:
    text = SPEC.replace("  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n", "")
    found = reasons(text + "limits: {seconds_per_cell: 1.0e-9}\n")
    assert found == {("undecided", WORDS[Reason.TIME_LIMIT])}
    assert WORDS[Reason.NO_DAMPING] in {reason for _, reason in reasons(text)}


@pytest.mark.parametrize("flag", [True, False])
def test_time_for_compiling_does_not_count(monkeypatch: pytest.MonkeyPatch, flag: bool) -> None:
    began, ended = time.monotonic(), False
    monkeypatch.setattr(alarm, "compiling_s", lambda: 0.3 if ended else time.monotonic() - began)
    halt = np.zeros(1)
    with Alarm(0.2, halt if flag else None) as waits:
        time.sleep(0.5)  # all of it spent compiling
        assert not waits.over
        ended = True  # 0.3 s of these were
        deadline = time.monotonic() + 120.0
        while not waits.over and time.monotonic() < deadline:
            time.sleep(0.01)
        assert waits.over


def test_an_alarm_without_a_limit_never_rings() -> None:
    halt = np.zeros(1)
    with Alarm(None, halt) as never:
        assert not never.over
        assert not never.limited
    with Alarm(1e6, halt) as late:
        assert late.limited
        assert not late.over
    with Alarm(0.0, halt) as now:
        deadline = time.monotonic() + 120.0
        while not now.over and time.monotonic() < deadline:
            time.sleep(0.01)
        assert now.over
    assert halt[0] > 0.0
    assert Alarm(0.0).over
    assert not Alarm(inf).over
