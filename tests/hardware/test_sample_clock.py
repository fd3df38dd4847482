"""A loop that did not run at its rate, and a clock that is not the computer's, are refused; late samples are not."""

import random

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.clock_drift import MOST_DRIFT, drift_fault
from hknob_cli.hardware.port import Block, Drift
from hknob_cli.hardware.sample_clock import MOST_OFF, SampleClock, fault_of
from hknob_cli.hardware.wire.host_clock import HostClock
from tests.hardware.trials import settings

TOLD = settings(1000)


def fault(time_us: np.ndarray, *, overruns: int = 0, simulated: bool = False) -> str:
    return fault_of(np.arange(time_us.size), time_us.astype(np.int64), TOLD, overruns=overruns, simulated=simulated)


@pytest.mark.parametrize("step", [1000.0, 1000.09, 999.91, 1009.0, 991.0])
def test_times_within_the_limit_pass(step: float) -> None:
    assert fault(np.floor(np.arange(500) * step)) == ""


@pytest.mark.parametrize(
    ("step", "said"),
    [(500, "50.0% too little"), (1020, "2.0% too much"), (980, "2.0% too little"), (1500, "50.0% too")],
)
def test_times_of_another_clock_are_named(step: float, said: str) -> None:
    assert said in fault(np.arange(500) * step)
    assert f"at most {MOST_OFF:.0%}" in fault(np.arange(500) * step)


@pytest.mark.parametrize("factor", [2, 3, 10])
@pytest.mark.parametrize("simulated", [False, True])
def test_a_loop_at_a_half_a_third_or_a_tenth_of_its_rate_is_in_no_cell(factor: int, *, simulated: bool) -> None:
    said = fault(np.arange(400) * 1000 * factor, simulated=simulated)
    assert said.startswith("the loop did not run at 1000 Hz: ")
    assert f"which is {1000 / factor:.4g} Hz, and does not say so" in said


def busy(share: float) -> tuple[np.ndarray, int]:
    """Times of a loop that is late now and then, by up to three periods, and how often it was."""
    dice, tick, times, overruns = random.Random(3), 0, [], 0
    for _ in range(2000):
        late = dice.uniform(0.5, 3.0) if dice.random() < share else 0.0
        times.append((tick + late) * 1000)
        overruns += late > 0.5
        tick += 1 + int(late)
    return np.array(times), overruns


def test_a_busy_computer_that_owns_up_is_let_pass_where_the_knob_is_simulated_and_only_there() -> None:
    times, overruns = busy(0.1)
    assert fault(times, overruns=overruns, simulated=True) == ""
    assert "the loop did not run at 1000 Hz" in fault(times, overruns=overruns)
    assert "and does not say so" in fault(times, overruns=0, simulated=True)


def test_some_late_samples_are_no_other_rate() -> None:
    times, overruns = busy(0.002)
    assert fault(times, overruns=overruns) == ""


def test_the_first_samples_are_enough() -> None:
    """A wrong rate is found before the wall is on."""
    clock = SampleClock(TOLD, simulated=False)
    block = Block(0, np.arange(100) * 2000, np.zeros(100, int), np.zeros(100), np.zeros(100), np.zeros(100, bool), 0)
    with pytest.raises(DeviceError, match="which is 500 Hz"):
        clock.take(block)


def arrivals(share: float, *, seconds: float, seed: int = 0) -> HostClock:
    """Blocks of 10 ms of a clock that is fast by a share, late by some ms, and now and then by 50 ms."""
    clock, dice = HostClock(), random.Random(seed)
    for i in range(1, int(seconds * 100)):
        late = dice.expovariate(1 / 0.002) + (0.05 * dice.random() if dice.random() < 0.2 else 0.0)
        clock.note(arrived_s=5.0 + i * 0.01 / (1.0 + share) + late, told_s=i * 0.01)
    return clock


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("share", [0.0, 1e-4, -0.005])
def test_a_clock_within_the_limit_passes_however_late_blocks_are(share: float, seed: int) -> None:
    drift = arrivals(share, seconds=2.0, seed=seed).drift()
    assert drift is not None
    assert drift_fault(drift) == ""
    assert abs(drift.share - share) <= drift.uncertainty


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("share", "seconds"), [(0.03, 2.0), (0.02, 4.0), (-0.02, 4.0), (-0.5, 0.5), (1.0, 0.8)])
def test_a_clock_beyond_the_limit_is_refused(share: float, seconds: float, seed: int) -> None:
    drift = arrivals(share, seconds=seconds, seed=seed).drift()
    assert drift is not None
    assert ("fast" if share > 0 else "slow") in drift_fault(drift)


def test_nothing_is_said_of_a_clock_that_was_heard_for_too_short() -> None:
    clock = HostClock()
    assert clock.fault() == ""
    assert arrivals(0.0, seconds=0.1).drift() is None
    assert drift_fault(None) == drift_fault(Drift(2 * MOST_DRIFT, 1.5 * MOST_DRIFT)) == ""
