"""The pulse on a knob by other means: formulas of the second order, and SciPy with events for friction."""

import numpy as np
from scipy.integrate import solve_ivp

from hknob_cli.apparatus.hand import Hand, SecondOrder


def step_response(hand: SecondOrder, times: np.ndarray) -> np.ndarray:
    """Angle [rad] per N·m of a step at 0, by the roots of J s² + B s + K; 0 before."""
    roots = np.roots([hand.inertia, hand.damping, hand.stiffness]).astype(complex)
    s1, s2 = roots
    t = np.maximum(times, 0.0)
    rise = 1.0 + (s2 * np.exp(s1 * t) - s1 * np.exp(s2 * t)) / (s1 - s2)
    return rise.real / hand.stiffness


def pulse_response(hand: SecondOrder, times: np.ndarray, torque: float, duration: float) -> np.ndarray:
    """Angle [rad] of a pulse that begins at 0."""
    return torque * (step_response(hand, times) - step_response(hand, times - duration))


def by_scipy(
    hand: Hand, stretches: list[tuple[float, float]], times: np.ndarray, *, coulomb: float, lag: float
) -> tuple[np.ndarray, int]:
    """Angle [rad] at ``times`` from rest under (torque, seconds), and how often friction caught or freed the knob."""

    def rest(y: np.ndarray, torque: float) -> tuple[np.ndarray, float]:
        """Rates without friction, and the torque on the knob that friction faces."""
        th, om, fa, fo, tau = y
        acting = tau if lag > 0.0 else torque
        rate = np.zeros(5)
        rate[0] = om
        if isinstance(hand, SecondOrder):
            pull = acting - hand.damping * om - hand.stiffness * th
        else:
            pad = hand.pad_damping * (om - fo) + hand.pad_stiffness * (th - fa)
            pull = acting - pad
            rate[2] = fo
            rate[3] = (pad - hand.finger_damping * fo - hand.finger_stiffness * fa) / hand.finger_inertia
        rate[4] = (torque - tau) / lag if lag > 0.0 else 0.0
        return rate, pull

    def moving(mode: int, torque: float):
        def rates(_, y):
            rate, pull = rest(y, torque)
            if mode == 0:
                rate[0] = rate[1] = 0.0
            else:
                rate[1] = (pull - mode * coulomb) / hand.inertia
            return rate

        return rates

    def until(mode: int, torque: float):
        def event(_, y):
            return coulomb - abs(rest(y, torque)[1]) if mode == 0 else mode * y[1]

        event.terminal, event.direction = True, -1.0
        return event

    y, now, events = np.zeros(5), 0.0, 0
    angle = np.zeros(len(times))
    for torque, span in stretches:
        end = now + span
        pull = rest(y, torque)[1]
        mode = int(np.sign(y[1])) if y[1] else (0 if abs(pull) <= coulomb else int(np.sign(pull)))
        while end - now > 1e-15:
            done = solve_ivp(
                moving(mode, torque),
                (now, end),
                y,
                method="DOP853",
                events=until(mode, torque) if coulomb > 0.0 else None,
                dense_output=True,
                rtol=1e-12,
                atol=1e-14,
                max_step=2e-4,
            )
            last = done.t[-1]
            inside = (times >= now - 1e-12) & (times <= last + 1e-12)
            angle[inside] = done.sol(np.clip(times[inside], now, last))[0]
            now, y = last, done.y[:, -1].copy()
            if done.status == 1:
                events += 1
                pull = rest(y, torque)[1]
                if mode == 0:
                    mode = int(np.sign(pull))
                else:
                    y[1] = 0.0
                    mode = 0 if abs(rest(y, torque)[1]) <= coulomb else int(np.sign(pull))
    return angle, events
