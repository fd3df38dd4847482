"""The count of an encoder with hysteresis: against relays, and how far a proven margin holds."""

from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.engine.follow import CYCLE_PROVEN
from hknob_cli.engine.general.advance import rub_many
from hknob_cli.engine.general.captured import FIELDS, captured
from hknob_cli.engine.general.controller import Controller, edge_gap, read_after
from hknob_cli.engine.general.hysteresis import pass_still, turn_and_count, way_at_most
from hknob_cli.engine.general.search import GeneralEngine, make_space
from hknob_cli.errors import ComputationError
from hknob_cli.scene.general_knob import sample_general, simulate
from hknob_cli.stages.dfa.run import DfaStage
from hknob_cli.stages.sweep.record import record_sweep
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import faults_of, loaded
from tests.engine.trial_space import trial_of

TEXT = """\
kind: sweep
name: small
scene:
  knob: {inertia: 1.9e-6}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {half_quantum: true}
  encoder: {hysteresis_counts: 0.5}
grid:
  sample_rate_hz: [1000]
  counts_per_rev: [1024]
starts: {angle: 0.02, velocity: 0.0, phases: 4}
"""


HAND = "hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}"
FINGER = "hand: {finger: {inertia: 3e-7, damping: 3e-4, stiffness: 0.5}, fingerpad: {damping: 1e-3, stiffness: 20.0}}"


def wall(hysteresis: float) -> Controller:
    return Controller(0.1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, float("inf"), 0.0, hysteresis=hysteresis)


@given(
    st.lists(st.integers(-400, 400).map(lambda n: n / 64.0), min_size=1, max_size=30),
    st.sampled_from([0.03125, 0.5, 1.0, 2.25, 7.0]),
)
def test_the_count_is_that_of_a_relay_at_every_edge(turns: list[float], width: float) -> None:
    """Turning points, one after another: relays of their own thresholds, the count the number of those that are on."""
    edges = range(-20, 20)
    count = float(np.floor(turns[0]))
    on = {edge: edge <= count for edge in edges}
    for x in turns[1:]:
        for edge in edges:
            if x >= edge + 0.5 * width:
                on[edge] = True
            elif x < edge - 0.5 * width:
                on[edge] = False
        before, count = count, read_after(x, count, wall(width))
        assert count == sum(on.values()) - 21  # the 20 edges from -20 to -1 are on at count -1
        gap = edge_gap(x, count, before, wall(width))
        assert gap >= 0.0
        for nearer in (-0.99 * gap, 0.99 * gap):
            if gap < float("inf"):
                assert min(read_after(x + nearer, before, wall(width)), 0.0) == min(count, 0.0)


def test_a_slack_in_radians_is_a_hysteresis_in_counts() -> None:
    plain = loaded(TEXT).scene
    slack = plain.encoder._replace(hysteresis_counts=0.2, backlash=0.3 * 2.0 * pi / 1024)  # type: ignore[union-attr]
    arguments: dict[str, Any] = {"sample_rate_hz": 1000.0, "counts_per_rev": 1024}
    both = sample_general(plain._replace(encoder=slack), **arguments).wall.hysteresis
    assert both == pytest.approx(sample_general(plain, **arguments).wall.hysteresis, rel=1e-14)


def test_a_trial_within_the_margin_keeps_the_readings() -> None:
    """The energy of a difference bounds its angle at all times, at turning points between samples, too."""
    knob = sample_general(loaded(TEXT).scene, sample_rate_hz=1000.0, counts_per_rev=1024)
    engine = GeneralEngine()
    arguments: dict[str, Any] = {"rate": knob.rate, "phases": 1, "delay_line": 0, "max_samples": None}
    (orbit,) = engine.search(knob.body, knob.wall, knob.start(0.02, 0.0), **arguments).attractors
    chart = engine.chart(knob.body, knob.wall, orbit)
    assert chart is not None
    pace = np.sqrt(knob.body.beta)
    for turn in np.linspace(0.0, 2.0 * np.pi, 16):
        away = 0.99 * orbit.margin
        x, v = orbit.x + away * np.cos(turn), orbit.v + away * pace * np.sin(turn)
        near = engine.chart(knob.body, knob.wall, orbit._replace(x=float(x), v=float(v)))
        assert near is not None
        assert commands_at_samples(near) == commands_at_samples(chart)


def test_a_trial_with_another_count_is_not_captured() -> None:
    """The state alone does not say what the next reading is."""
    knob = sample_general(loaded(TEXT).scene, sample_rate_hz=1000.0, counts_per_rev=1024)
    row = [float(CYCLE_PROVEN), 20.0, 0.1, 0.1, 0.0, 1e-12, 1.0, 0.0, 0.0, -1.0]
    assert len(row) == FIELDS
    state = [-0.1, 0.01]
    for before, expected in ((-1.0, 0), (0.0, -1), (-2.0, -1)):
        space = make_space(2, 0, lambda count: [0.0] * count)
        trial = trial_of(state, [], space, [row], [state])
        assert captured(trial, before, 0, knob.body, knob.wall) == expected


def commands_at_samples(chart: Any) -> list[float]:
    """Command that acts from each sample on."""
    starts = np.concatenate([[0.0], np.cumsum(chart.spans)[:-1]])
    whole = np.abs(starts - np.rint(starts)) < 1e-9
    return [float(command) for command in chart.commands[whole]]


def test_a_recording_is_the_trials_motion() -> None:
    record = "record: {duration: 0.25, interval: 0.01}\n"
    plan = loaded(TEXT.replace(", phases: 4", ", phases: 2") + record)
    rows = record_sweep(plan).to_pylist()
    trial = simulate(
        plan.scene,
        sample_rate_hz=1000.0,
        counts_per_rev=1024,
        angle_rad=0.02,
        velocity_rad_s=0.0,
        phase=0.25,
        samples=240,
    )
    sampled = [row for row in rows if row["event"] == "sample"][:241]
    assert [row["angle_rad"] for row in sampled] == pytest.approx(trial.angle_rad, abs=1e-13)
    assert [row["torque_nm"] for row in sampled] == pytest.approx(trial.torque_nm, abs=1e-13)
    assert max(row["torque_nm"] for row in sampled) > 0.0


DAMPED = TEXT.replace("wall: {stiffness: 0.27}", "wall: {stiffness: 0.27, damping: 1.0e-5}")


def test_virtual_damping_beside_it_is_that_of_a_controller_without_effect() -> None:
    """The wall as a law, and a controller that damps by 0: the same cells, orbits and recordings."""
    idle = "  controller: {kind: velocity_damping, damping: 0.0}\ngrid:"
    record = "record: {duration: 0.05, interval: 0.0007}\n"
    one, other = loaded(DAMPED + record), loaded(DAMPED.replace("grid:", idle) + record)
    assert record_sweep(one).to_pylist() == record_sweep(other).to_pylist()
    by_wall, by_law = SweepStage(one, jobs=1).run(), SweepStage(other, jobs=1).run()
    assert by_wall.cells.to_pylist() == by_law.cells.to_pylist()
    assert by_wall.orbits.to_pylist() == by_law.orbits.to_pylist()
    (cell,) = by_wall.cells.to_pylist()
    assert cell["certified_fraction"] == 1.0


def test_a_grid_may_have_it_with_and_without_virtual_damping() -> None:
    both = SweepStage(loaded(TEXT.replace("grid:", "grid:\n  wall.damping: [0.0, 1.0e-5]")), jobs=1).run()
    alone = [SweepStage(loaded(text), jobs=1).run() for text in (TEXT, DAMPED)]
    found = [row for one in alone for row in one.orbits.to_pylist()]
    assert [row["p2p_rad"] for row in both.orbits.to_pylist()] == [row["p2p_rad"] for row in found]
    assert len({row["p2p_rad"] for row in found}) == 2


def test_the_loop_without_a_law_says_that_it_does_not_take_both() -> None:
    plan = loaded(DAMPED)
    with pytest.raises(ComputationError, match="is followed under a law"):
        sample_general(plan.scene, sample_rate_hz=1000.0, counts_per_rev=1024)


def test_without_a_width_nothing_changes() -> None:
    """No engine of its own, no other numbers."""
    zero = loaded(TEXT.replace("hysteresis_counts: 0.5", "hysteresis_counts: 0.0, backlash: 0.0"))
    absent = loaded(TEXT.replace("  encoder: {hysteresis_counts: 0.5}\n", ""))
    tables = [SweepStage(plan, jobs=1).run() for plan in (zero, absent)]
    assert tables[0].cells.equals(tables[1].cells)
    assert tables[0].orbits.equals(tables[1].orbits)


def test_the_faster_the_clock_the_nearer_the_relays_of_all_harmonics() -> None:
    """The sweep knows nothing of describing functions; the hold's half sample is all that they approximate."""
    plan = loaded(TEXT.replace("[1000]", "[4000, 64000]"))
    sweep = SweepStage(plan, jobs=1).run().cells.to_pylist()
    text = TEXT.replace("kind: sweep", "kind: dfa").replace("[1000]", "[4000, 64000]")
    text = text.replace(STARTS, "methods: [tsypkin]")
    dfa = DfaStage(loaded(text)).run().to_pylist()  # type: ignore[arg-type]
    for tolerance, found, formula in zip((0.05, 0.005), sweep, dfa, strict=True):
        assert found["certified_fraction"] == 1.0
        assert formula["in_domain"]
        assert formula["p2p_rad"] == pytest.approx(found["p2p_rad"], rel=tolerance)
        assert formula["frequency_hz"] == pytest.approx(found["frequency_hz"], rel=tolerance)


def test_the_pitch_of_one_harmonic_needs_neither_clock_nor_counts() -> None:
    """w^3 = 4 K b / (pi h J^2), the hand's spring left out: docs/explanation/describing_functions.md."""
    text = TEXT.replace("hysteresis_counts: 0.5", "hysteresis_counts: 1.0").replace("[1000]", "[64000]")
    text = text.replace("kind: sweep", "kind: dfa").replace("[1024]", "[512, 4096]")
    text = text.replace(STARTS, "methods: [df1]")
    pitch = (4.0 * 0.27 * 3.45e-4 / (pi * 2.2e-6**2)) ** (1.0 / 3.0) / (2.0 * pi)
    assert pitch == pytest.approx(46.2, abs=0.05)
    for row in DfaStage(loaded(text)).run().to_pylist():  # type: ignore[arg-type]
        assert row["frequency_hz"] == pytest.approx(pitch, rel=0.04)


def test_what_dfa_has_no_word_on_is_told() -> None:
    text = TEXT.replace("kind: sweep", "kind: dfa").replace(
        "inertia: 1.9e-6", "inertia: 1.9e-6, coulomb_torque: 1.0e-5"
    )
    text = text.replace(STARTS, "methods: [df1, staircase]")
    rows = DfaStage(loaded(text)).run().to_pylist()  # type: ignore[arg-type]
    assert [row["p2p_rad"] for row in rows] == [None, None]
    assert "one relay cannot be both" in rows[0]["reason"]
    assert "its wall has no memory" in rows[1]["reason"]


PLACE = "scene.encoder.hysteresis_counts"
STARTS = "starts: {angle: 0.02, velocity: 0.0, phases: 4}"


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("hysteresis_counts: 0.5", "hysteresis_counts: -0.5", f"spec.yaml:8:32: {PLACE}: must be >= 0, got -0.5"),
        ("hysteresis_counts: 0.5", "hysteresis: 0.5", "hysteresis_counts"),
        ("hysteresis_counts: 0.5", "backlash: 1 kg", "spec.yaml:8:23: scene.encoder.backlash"),
        ("velocity: 0.0, phases: 4", "velocity: 0.0, basins: 2", "basins"),
        (
            STARTS,
            "starts: anywhere",
            f"{PLACE}: must be absent where starts are anywhere",
        ),
        (
            "starts:",
            "growth: {duration: 1.0}\nstarts:",
            f"{PLACE}: must be absent where 'growth' is given",
        ),
    ],
)  # fmt: skip
def test_faults_say_where_what_and_why(old: str, new: str, fault: str) -> None:
    assert fault in faults_of(TEXT.replace(old, new))


@pytest.mark.parametrize("controller", ["bounded_lag", "half_sample"])
def test_a_controller_reads_the_count_that_stays(controller: str) -> None:
    """Virtual damping goes along. One so narrow that no count stays behind changes nothing, to rounding."""
    law = TEXT.replace(
        "wall: {stiffness: 0.27}", f"wall: {{stiffness: 0.27, damping: 1.0e-5}}\n  controller: {{kind: {controller}}}"
    )
    plain, tiny, wide = (
        SweepStage(loaded(law.replace("hysteresis_counts: 0.5", f"hysteresis_counts: {width}")), jobs=1).run()
        for width in ("0.0", "1.0e-9", "1.5")
    )
    rows = [tables.cells.to_pylist()[0] for tables in (plain, tiny, wide)]
    largest = [max(tables.orbits.column("p2p_rad").to_pylist()) for tables in (plain, tiny, wide)]
    assert [row["certified_fraction"] for row in rows] == [1.0, 1.0, 1.0]
    assert largest[1] == pytest.approx(largest[0], rel=1e-6)
    assert largest[2] > 1.2 * largest[0]


def test_a_velocity_sensor_beside_hysteresis_is_labelled() -> None:
    law = TEXT.replace("grid:", "  controller: {kind: half_sample, velocity: sensor}\ngrid:")
    assert SweepStage(loaded(law), jobs=1).run().cells.to_pylist()[0]["certified_fraction"] == 0.0


@pytest.mark.parametrize("still", [0.0, 1e-15])
def test_a_body_that_has_settled_is_passed_over(still: float) -> None:
    """A finger at rest but for roundings, whose turning points would be met without end; one that moves is not."""
    knob = sample_general(loaded(TEXT.replace(HAND, FINGER)).scene, sample_rate_hz=1000.0, counts_per_rev=1024)
    body, pad = knob.body, [0.0] * 8
    u = knob.body.push  # balances the push: all rest at 0
    z = [still, -still, still, still]
    most = way_at_most(z, u, 1.0, body, pad)
    assert most <= 1e3 * still
    shown, margin = turn_and_count(z, u, 1.0, 0.0, body, knob.wall, pad)
    assert shown == 0.0
    assert margin == still + 0.25 - most  # to the edge of the way down, half a hysteresis of 0.5 below
    assert max(map(abs, z)) <= 100.0 * still
    assert way_at_most([1e-6, 0.0, 0.0, 0.0], u, 1.0, body, pad) > 1e-7
    moved, other = [0.3, 0.01, -0.02, 0.03], [0.3, 0.01, -0.02, 0.03]
    pass_still(moved, u, 0.7, body, pad)
    rub_many(other, u, 0.7, body, pad)
    assert moved == pytest.approx(other, rel=1e-12)
