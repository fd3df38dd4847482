"""Virtual trials against SciPy's DOP853 with events: a target, a knob and a person written down a second time."""

from math import floor, tau

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.port import Settings, Simulated, Sine
from tests.hardware.trials import FRICTION, HAND, settings, virtual_trial

NATIVE = 2**17 * 5
WANDERING = HAND._replace(push_sines=(Sine(2e-4, 9.0, 0.3), Sine(1e-4, 0.7, 2.0)))


class Body:
    """State (angle, speed, torque of the amplifier); it slides (mode -1 or 1), is held (0), or has no friction (2)."""

    def __init__(self, knob: Simulated, lag_s: float) -> None:
        self.knob, self.lag = knob, lag_s
        self.y = np.array([knob.angle_rad, 0.0, 0.0])

    def pull(self, y: np.ndarray, command: float, push: float) -> float:
        acting = y[2] if self.lag else command
        return acting - push - self.knob.damping * y[1] - self.knob.stiffness * y[0]

    def mode(self, command: float, push: float) -> int:
        if self.knob.coulomb_nm == 0.0:
            return 2
        if self.y[1] != 0.0:
            return int(np.sign(self.y[1]))
        pull = self.pull(self.y, command, push)
        return 0 if abs(pull) <= self.knob.coulomb_nm else int(np.sign(pull))

    def move(self, command: float, push: float, span: float) -> None:
        now = 0.0
        while span - now > 1e-12 * span:
            mode = self.mode(command, push)

            def rates(_, y, mode=mode):
                torque = (command - y[2]) / self.lag if self.lag else 0.0
                if mode == 0:
                    return [0.0, 0.0, torque]
                rub = mode * self.knob.coulomb_nm if mode != 2 else 0.0
                return [y[1], (self.pull(y, command, push) - rub) / self.knob.inertia, torque]

            def ends(_, y, mode=mode):
                if mode == 0:
                    return self.knob.coulomb_nm - abs(self.pull(y, command, push))
                return mode * y[1] if mode != 2 else 1.0

            ends.terminal, ends.direction = True, -1.0
            done = solve_ivp(
                rates, (now, span), self.y, method="DOP853", events=ends, rtol=1e-11, atol=1e-14, max_step=span / 4
            )
            now, self.y = done.t[-1], done.y[:, -1].copy()
            if done.status == 1:
                if mode == 0:
                    self.y[1] = 1e-12 * np.sign(self.pull(self.y, command, push))
                else:
                    self.y[1] = 0.0


def reference(told: Settings, knob: Simulated, samples: int, lag_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Native counts and torques from the start on, by the words of docs/reference/wire.md."""
    body, counts, torques, before = Body(knob, lag_s), [], [], None
    quantum, interval = tau / told.counts_per_rev, told.period_ns * 1e-9
    for i in range(samples):
        angle = floor(body.y[0] / (tau / NATIVE))
        coarse = floor(angle * told.counts_per_rev / NATIVE)
        torque = 0.0
        if coarse < 0:
            step = coarse - (coarse if before is None else before)
            torque = -told.wall_stiffness * coarse * quantum - told.wall_damping * step * quantum / interval
            torque = min(max(torque, -told.torque_limit_nm), told.torque_limit_nm)
        before = coarse
        t = i * interval
        push = knob.push_nm + sum(a * np.sin(tau * f * t + phase) for a, f, phase in knob.push_sines)
        counts.append(angle)
        torques.append(torque)
        body.move(torque, max(0.0, push), interval)
    return np.array(counts), np.array(torques)


@pytest.mark.parametrize(
    ("knob", "told", "lag"),
    [
        (WANDERING, settings(1000, 512), 0.0),
        (WANDERING._replace(coulomb_nm=FRICTION), settings(1000, 512), 0.0),
        (WANDERING._replace(coulomb_nm=FRICTION), settings(1000, 512, wall_damping=2e-4), 2e-4),
        (WANDERING, settings(455, 256, torque_limit_nm=5e-3), 2e-4),
    ],
)
def test_a_trial_goes_the_same_way(knob: Simulated, told: Settings, lag: float) -> None:
    """The same torque at every sample, and the same count but where the integrator's error (1e-9 rad) meets an edge."""
    samples = 300
    got = virtual_trial(told, knob, duration_s=samples * told.interval_s, nuisances=Nuisances(amplifier_s=lag))
    counts, torques = reference(told, knob, samples, lag)
    running = np.flatnonzero(got.running)[:samples]
    off = np.abs(got.angle_counts[running] - counts)
    assert off.max() <= 1
    assert off.sum() <= 1
    assert np.abs(got.torque_nm[running] - torques).max() <= 2.0**-24 * np.abs(torques).max()
    assert np.count_nonzero(np.diff(torques)) > 30
