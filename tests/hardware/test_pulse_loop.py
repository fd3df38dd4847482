"""The loop of a pulse: motion against the apparatus' engine and 60 digits, sensors against the equations."""

from math import pi, tau

import numpy as np
import pytest

from hknob_cli.apparatus.hand import SecondOrder, follow, mechanism
from hknob_cli.errors import DeviceError
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.hardware.person import grip_of, squeezer, squeezing_hand
from hknob_cli.hardware.virtual import NATIVE_COUNTS, VirtualDevice
from tests.hardware.pulses import SPEC, planned, pulsed

COUNT = tau / NATIVE_COUNTS
DT = 1e-4
HEAVY = "knob: {inertia: 9.0e-6, damping: 1.0e-4, coulomb_torque: 1.2e-3}\n"
FREE = "knob: {inertia: 1.98e-6, coulomb_torque: 0}\n"
CASES = {
    "printed": (SPEC, None, 0.56e-3),
    "heavy, rubbing": (SPEC + HEAVY, None, 1.2e-3),
    "free": (SPEC + FREE, None, 0.0),
    "lagging": (SPEC + FREE, Nuisances(amplifier_s=3e-4), 0.0),
    "lagging, rubbing": (SPEC, Nuisances(amplifier_s=5e-5), 0.56e-3),
}


def truth(text: str, number: int, fired_at: int) -> SecondOrder:
    """The hand at the pulse, which came so many samples after the start."""
    plan = planned(text)
    squeeze = squeezer(plan, trials_of(plan)[number - 1]).squeeze
    assert squeeze
    return squeezing_hand(squeeze, float(grip_of(squeeze, np.array([fired_at * DT]), None)[0]))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("number", [1, 3])
@pytest.mark.parametrize("name", CASES)
def test_the_motion_is_that_of_the_apparatus(name: str, number: int) -> None:
    """Two engines: steps with events here, tables of matrix exponentials there. A count is the encoder's floor."""
    text, nuisances, coulomb = CASES[name]
    block = pulsed(text, nuisances=nuisances, number=number)
    on = int(np.argmax(block.running))
    onset = int(np.flatnonzero(block.torque_nm)[0])
    width = int(np.count_nonzero(block.torque_nm))
    assert width == 200
    hand = truth(text, number, onset - on)
    lag = nuisances.amplifier_s if nuisances else 0.0
    body = mechanism(hand, coulomb=coulomb, lag_s=lag)
    states = follow(body, body.rest(0.0), [(block.torque_nm[onset].item(), width), (0.0, 800)], DT)
    turned = (block.angle_counts[onset : onset + 1001] - block.angle_counts[onset]) * COUNT
    # Floors of two angles differ by less than a count; the torque that acts is not rounded to single precision.
    bound = COUNT * (1.0 + 1e-9) + 2.0**-24 * float(np.abs(states[:, 0]).max())
    assert np.abs(turned - states[:, 0]).max() <= bound
    assert float(turned.max()) > 0.02
    assert (block.angle_counts[: onset + 1] == block.angle_counts[0]).all()


def test_the_motion_at_60_digits() -> None:
    """Without friction the angle is a sum of exponentials: the closed form in 60 digits, sample by sample."""
    import mpmath

    block = pulsed(SPEC + FREE, number=2)
    on, onset = int(np.argmax(block.running)), int(np.flatnonzero(block.torque_nm)[0])
    hand = truth(SPEC + FREE, 2, onset - on)
    plan = planned(SPEC + FREE)
    torque = settings_of(plan, trials_of(plan)[1]).pulse.torque_nm
    rest = squeezer(plan, trials_of(plan)[1]).angle_rad
    with mpmath.workdps(60):
        j, b, k, height = (mpmath.mpf(one) for one in (*hand, torque))
        root = mpmath.sqrt(mpmath.mpc((b / j) ** 2 / 4 - k / j))
        low, high = -b / j / 2 - root, -b / j / 2 + root

        def step(t: float) -> mpmath.mpf:
            """Angle a time after a torque was switched on for good."""
            if t <= 0:
                return mpmath.mpf(0)
            t = mpmath.mpf(t)
            return mpmath.re(
                height / k * (1 - (high * mpmath.exp(low * t) - low * mpmath.exp(high * t)) / (high - low))
            )

        for i in range(0, 600, 7):
            angle = step(mpmath.mpf(i) / 10_000) - step(mpmath.mpf(i - 200) / 10_000)
            counts = (mpmath.mpf(rest) + angle) / (2 * mpmath.pi / NATIVE_COUNTS)
            edge = abs(counts - mpmath.nint(counts))
            if edge > 1e-6:  # of a count, far above the rounding of doubles
                assert block.angle_counts[onset + i] == int(mpmath.floor(counts))


@pytest.mark.parametrize("lag", [0.0, 2e-4])
def test_the_sensors_obey_the_equation_of_motion(lag: float) -> None:
    """Torque by the closed form of the lag; acceleration by differences of the angle, away from the torque's steps."""
    text = SPEC.replace("pulses: {", "pulses: {sensors: {torque_noise: 0, acceleration_noise: 0}, ")
    block = pulsed(text + FREE, nuisances=Nuisances(amplifier_s=lag))
    assert block.measured_torque_nm is not None
    assert block.acceleration_rad_s2 is not None
    onset = int(np.flatnonzero(block.torque_nm)[0])
    t = (np.arange(block.torque_nm.size) - onset) * DT
    height = block.torque_nm[onset]
    if lag:
        on, off = np.maximum(t, 0.0), np.maximum(t - 0.02, 0.0)
        acting = height * (np.exp(-off / lag) - np.exp(-on / lag))
    else:
        acting = block.torque_nm
    assert np.abs(block.measured_torque_nm - acting).max() < 1e-6 * height
    # Second differences have the noise of four rounded counts: 30 samples apart it is 4 counts / (3 ms)².
    apart = 30
    angle = block.angle_counts * COUNT
    second = (angle[2 * apart :] - 2.0 * angle[apart:-apart] + angle[: -2 * apart]) / (apart * DT) ** 2
    told = block.acceleration_rad_s2[apart:-apart]
    smooth = (np.abs(t[apart:-apart] - 0.01) < 0.006) | (t[apart:-apart] > 0.025)
    bound = 4.0 * COUNT / (apart * DT) ** 2
    plan = planned(text + FREE)
    hand = squeezer(plan, trials_of(plan)[0])
    # A third derivative turns by the fastest pole; its share over the span, by Taylor: (apart dt)² / 12 of the fourth.
    pole = max(abs(np.roots([hand.inertia, hand.damping, hand.stiffness])))
    bend = (apart * DT) ** 2 / 12.0 * pole**2 * float(np.abs(told).max())
    late = np.abs(t[apart:-apart] - 0.01) > 0.015
    assert np.abs(second - told)[smooth & late].max() < bound + bend
    assert float(np.abs(told).max()) > 500.0


QUIET = SPEC.replace("pulses: {", "pulses: {sensors: {torque_noise: 0, torque_sees_friction: SEES}, ")


@pytest.mark.parametrize("lag", [0.0, 2e-4])
def test_a_sensor_that_carries_the_motor_reads_what_turns_the_hand(lag: float) -> None:
    """Under the printed friction, from the angle alone: J x'' + B x' + K x of the motion that was recorded."""
    nuisances = Nuisances(amplifier_s=lag)
    block, other = (pulsed(QUIET.replace("SEES", sees), nuisances=nuisances) for sees in ("true", "false"))
    assert np.array_equal(block.angle_counts, other.angle_counts)
    told, motor = block.measured_torque_nm, other.measured_torque_nm
    assert told is not None
    assert motor is not None
    onset = int(np.flatnonzero(block.torque_nm)[0])
    plan = planned(QUIET.replace("SEES", "true"))
    hand = squeezer(plan, trials_of(plan)[0])
    assert hand.coulomb_nm == 5.6e-4
    angle = block.angle_counts * COUNT - hand.angle_rad
    # While it slides one way friction takes its level, of that way.
    apart = 20
    speed = np.zeros(angle.size)
    speed[apart:-apart] = (angle[2 * apart :] - angle[: -2 * apart]) / (2 * apart * DT)
    after = np.arange(angle.size) - onset
    slides = (after > 20) & (after < 600) & (np.abs(speed) > 0.5)
    assert slides.sum() > 150
    taken = motor - told
    assert np.abs(taken[slides] - 5.6e-4 * np.sign(speed[slides])).max() < 1e-9
    # Where it stands still, the hand's spring is all that there is to read.
    last = slice(-200, None)
    assert np.ptp(block.angle_counts[last]) == 0
    middle = angle[last] + 0.5 * COUNT
    squeezed_at = truth(QUIET.replace("SEES", "true"), 1, onset - int(np.argmax(block.running)))
    assert np.abs(told[last] - squeezed_at.stiffness * middle).max() < 0.6 * squeezed_at.stiffness * COUNT + 1e-9
    assert np.abs(taken).max() <= 5.6e-4 * (1.0 + 1e-6)


def test_noise_of_the_sensors_is_as_asked_for() -> None:
    text = SPEC.replace("pulses: {", "pulses: {sensors: {torque_noise: 2.0e-5, acceleration_noise: 5.0}, ")
    block = pulsed(text)
    assert block.measured_torque_nm is not None
    assert block.acceleration_rad_s2 is not None
    quiet = slice(0, int(np.flatnonzero(block.torque_nm)[0]))
    count = quiet.stop
    for values, rms in ((block.measured_torque_nm, 2e-5), (block.acceleration_rad_s2, 5.0)):
        assert float(values[quiet].std()) == pytest.approx(rms, rel=5.0 / np.sqrt(2.0 * count))
        assert abs(float(values[quiet].mean())) < 5.0 * rms / np.sqrt(count)


def test_without_sensors_there_are_none() -> None:
    block = pulsed()
    assert block.measured_torque_nm is None
    assert block.acceleration_rad_s2 is None


def test_a_sensor_changes_no_other_sample() -> None:
    text = SPEC.replace("pulses: {", "pulses: {sensors: {torque_noise: 2.0e-5}, ")
    plain, sensed = pulsed(), pulsed(text)
    for name in ("time_us", "angle_counts", "torque_nm", "grip_n", "running"):
        assert np.array_equal(getattr(plain, name), getattr(sensed, name))


def test_a_knob_that_nobody_squeezes_is_not_armed() -> None:
    plan = planned()
    trial = trials_of(plan)[0]
    device = VirtualDevice()
    device.configure(settings_of(plan, trial), squeezer(plan, trial)._replace(squeeze=()))
    with pytest.raises(DeviceError, match="nobody squeezes its knob"):
        device.arm()


def test_late_samples_move_the_knob_for_as_long_as_they_take() -> None:
    """A clock that jitters and leaves out ticks: the hand's time is the device's time."""
    block = pulsed(SPEC + FREE, nuisances=Nuisances(late_share=0.2, seed=3))
    onset = int(np.flatnonzero(block.torque_nm)[0])
    assert block.overruns > 100
    plan = planned(SPEC + FREE)
    squeeze = squeezer(plan, trials_of(plan)[0]).squeeze
    assert squeeze
    cell = block.grip_n - block.grip_n[: int(np.argmax(block.running))].mean()
    at = (block.time_us - block.time_us[int(np.argmax(block.running))]) * 1e-6
    before = slice(int(np.argmax(block.running)), onset + 1)
    force = grip_of(squeeze, at[before], None)
    # Told to 1 us, and in single precision.
    assert np.abs(cell[before] - force).max() < 2e-6 * 0.71 / 0.2 * pi + 1e-6
