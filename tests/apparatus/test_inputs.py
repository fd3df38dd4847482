"""Inputs other than a pulse: what they are, the motion that they make, and that hands come back from it."""

import numpy as np
import pytest
from scipy.signal import cont2discrete

from hknob_cli.apparatus.experiment import Schedule, record_experiments
from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.apparatus.hand_recording import Rig, binary_sequence, runs, scaled_input, unit_input
from hknob_cli.apparatus.people import Variation, mean_hand
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.prepare import Preparation, conditions
from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import ResultSet
from hknob_cli.specs.identification import InputPlan
from tests.apparatus.truths import truths
from tests.conftest import loaded

DT = 1e-4
KINDS = ("step", "ramp", "sine", "chirp", "noise", "prbs")


def plan(kind: str, duration: float = 0.2) -> InputPlan:
    return InputPlan(kind, duration, 5.0, 80.0, 2e-3)


def test_the_sequence_has_the_properties_of_a_maximal_one() -> None:
    """In 511 chips one 1 more than -1, and at every other shift a correlation of -1 in 511 (Golomb)."""
    once = binary_sequence(511)
    assert set(once) == {-1.0, 1.0}
    assert once.sum() == 1.0
    spectrum = np.abs(np.fft.fft(once)) ** 2
    shifted = np.real(np.fft.ifft(spectrum))
    assert shifted[0] == pytest.approx(511.0)
    assert shifted[1:] == pytest.approx(-1.0, abs=1e-9)
    assert np.array_equal(binary_sequence(1022), np.tile(once, 2))


def test_what_the_inputs_are() -> None:
    for kind in KINDS:
        values = unit_input(plan(kind), DT)
        assert len(values) == 2000
        assert np.max(np.abs(values)) == pytest.approx(1.0, abs=1e-3)
    assert (unit_input(plan("step"), DT) == 1.0).all()
    assert np.diff(unit_input(plan("ramp"), DT)) == pytest.approx(1.0 / 2000)
    crossings = np.count_nonzero(np.diff(np.sign(unit_input(plan("sine", 1.0), DT)[1:])))
    assert crossings == 9  # 5 periods in a second
    # Twice the mean frequency times the duration: (5 + 80)/2 Hz, 42.5 periods in a second.
    crossings = np.count_nonzero(np.diff(np.sign(unit_input(plan("chirp", 1.0), DT)[1:])))
    assert crossings == pytest.approx(85, abs=1)
    for kind in ("noise", "prbs"):
        assert all(count % 20 == 0 for _, count in runs(unit_input(plan(kind), DT)))  # chips of 2 ms
    assert np.array_equal(unit_input(plan("noise"), DT), unit_input(plan("noise"), DT))


def test_a_step_is_as_high_as_its_overshoot_allows() -> None:
    """The first peak of a step is T/K (1 + exp(-pi zeta / sqrt(1 - zeta^2)))."""
    hand = mean_hand(1, 0.71)
    zeta = hand.damping / (2.0 * (hand.inertia * hand.stiffness) ** 0.5)
    most = (1.0 + np.exp(-np.pi * zeta / (1.0 - zeta**2) ** 0.5)) / hand.stiffness
    # Between two samples the peak is at most (w dt)^2 / 8 of the overshoot higher than at them.
    assert scaled_input(plan("step"), hand, DT, 0.09)[0] == pytest.approx(0.09 / most, rel=1e-4)


@pytest.mark.parametrize("kind", KINDS)
def test_the_recorded_motion_is_the_exact_one_in_counts(kind: str) -> None:
    """Against SciPy's discretisation of the hand, stepped by hand; the encoder rounds down."""
    rig = Rig.ideal()
    chosen = Schedule(experiments=[1], subjects=1, blocks=1, trials=1, grips=[0.71])
    (trial,) = record_experiments(rig, chosen, torque=plan(kind))
    (hand,) = truths(chosen).values()
    rates = np.array([[0.0, 1.0], [-hand.stiffness / hand.inertia, -hand.damping / hand.inertia]])
    move, push, *_ = cont2discrete((rates, np.array([[0.0], [1.0 / hand.inertia]]), np.eye(2), np.zeros((2, 1))), DT)
    state, angle = np.zeros(2), []
    for torque in trial.torque_nm:
        angle.append(state[0])
        state = move @ state + push[:, 0] * torque
    above = np.array(angle) - trial.angle_rad
    assert above.min() > -1e-9
    assert above.max() < rig.count_rad + 1e-9
    assert len(trial.time_s) == 50 + 2000 + 1
    assert (trial.torque_nm[:50] == 0.0).all()


def test_the_grip_is_held_and_the_rest_is_as_with_a_pulse() -> None:
    chosen = Schedule(experiments=[1], subjects=1, blocks=1, trials=1, grips=[2.4])
    (long,) = record_experiments(Rig(), chosen, torque=plan("sine"))
    assert long.grip_n is not None
    assert np.mean(long.grip_n[50:]) == pytest.approx(2.4, abs=0.005)
    assert long.grip_n[50] >= 2.4
    assert np.max(long.grip_n) < 2.46


@pytest.mark.parametrize("kind", KINDS)
def test_hands_come_back(kind: str) -> None:
    """Within five standard errors, and a hundredth: the encoder's steps are no white noise."""
    chosen = Schedule(experiments=[1], subjects=1, blocks=1, trials=1, grips=[0.71])
    still = Variation.none()
    trials = record_experiments(Rig.ideal(), chosen, torque=plan(kind, 0.5), variation=still)
    (one,) = conditions(trials, Preparation(decimate=1, continuous=True, free_start=True), counts_per_rev=640_000)
    (true,) = truths(chosen, variation=still).values()
    assert one.motion is not None
    fit = output_error(one.motion)
    for name in SecondOrder._fields:
        found = fit.parameters[name]
        assert abs(found.value - getattr(true, name)) < 5.0 * found.std + 0.01 * getattr(true, name), name


def test_the_power_of_inputs_by_hand() -> None:
    """A binary sequence has the largest mean square that there is, twice that of a sine of whole periods."""
    assert compute("input_power", ResultSet({}), {"kind": "prbs", "over": "step"}) == 1.0


def test_the_angle_of_a_slow_sine_is_a_sine() -> None:
    """Far below the hand's resonance the angle is T/K sin: mean square one half; a step's is near 1, its overshoot off.

    At 2 Hz, a whole period in half a second, inertia and damping turn the sine by less than 0.11 rad, and what it
    begins with fades within 10 ms: 2 % of the half second, and of the mean square.
    """
    given = {"kind": "sine", "over": "sine", "experiment": 1, "grip_n": 14.2}
    assert compute("turned_power", ResultSet({}), given) == 1.0
    hand = mean_hand(1, 14.2)
    step = scaled_input(plan("step", 0.5), hand, DT, 0.09)[0] / hand.stiffness / 0.09
    found = compute("turned_power", ResultSet({}), {**given, "over": "step", "sine_hz": 2.0})
    assert found == pytest.approx(0.5 / step**2, rel=0.05)
    half = compute("input_power", ResultSet({}), {"kind": "prbs", "over": "sine", "duration_s": 1.0})
    assert half == pytest.approx(2.0, rel=1e-6)


SPEC = """\
kind: sysid
name: small
virtual: {experiments: [1], subjects: 1, blocks: 1, trials: 1, grips: [0.71], input: {kind: chirp, duration: 200 ms}}
excitation: continuous
prepare: {average: false}
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("excitation: continuous\n", "", "excitation: must be continuous where virtual.input is given"),
        ("kind: chirp", "kind: square", "virtual.input.kind: must be"),
        ("duration: 200 ms", "duration: 20 s", "virtual.input.duration: must be <= 10"),
        ("duration: 200 ms", "duration: 10 s, chip: 0", "virtual.input.chip: must be > 0"),
        ("kind: sysid", "kind: sysid\nwhat: apparatus", "virtual.input: must be absent where what is no hand"),
        ("subjects: 1, blocks: 1, trials: 1", "subjects: 9, blocks: 9, trials: 999", "must make at most 16250 trials"),
    ],
)
def test_faults_have_their_place(old: str, new: str, said: str) -> None:
    from hknob_cli.errors import SpecError

    assert loaded(SPEC).virtual.input == InputPlan("chirp", 0.2, 1.0, 100.0, 0.002)
    with pytest.raises(SpecError) as error:
        loaded(SPEC.replace(old, new))
    assert said in str(error.value)
