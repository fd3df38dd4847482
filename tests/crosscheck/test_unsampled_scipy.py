"""The motion without a sample clock against SciPy's DOP853, stopped at every event as the source did with ode23.

The solver's events lie on a dense output of seventh order: with steps of 1e-4 s, a thirtieth of a radian against the
wall, its error is some 1e-11 of a step's change. 1e-9 rad over some tens of events is ten times what that adds up to.
"""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hknob_cli.measure.unsampled import events
from hknob_cli.scene.plain_knob import reduce_unsampled
from hknob_cli.specs.scene import SceneSpec

WITHIN_RAD = 1e-9


def solved(scene: dict[str, Any], counts: int, angle: float, velocity: float, times: np.ndarray) -> np.ndarray:
    """Angle at ``times``; level -1, -2, ... inside the wall, 0 outside; the encoder rounds down."""
    inertia = scene["knob"]["inertia"]
    friction, damping = scene["knob"].get("coulomb_torque", 0.0), scene["knob"].get("damping", 0.0)
    hand = scene.get("hand", {}).get("stiffness", 0.0)
    wall, bias = scene["wall"]["stiffness"], scene["bias"]["torque"]
    counted = scene.get("encoder") != "none"
    q = 2.0 * np.pi / counts

    def torque(theta: float, level: int) -> float:
        if counted:
            return -wall * level * q
        return -wall * theta if level < 0 else 0.0

    t, state = 0.0, [angle, velocity]
    level = min(int(np.floor(angle / q)), 0) if counted else (-1 if angle < 0.0 else 0)
    way = float(np.sign(velocity))
    out = np.full(len(times), np.nan)
    done = 0
    while t < times[-1]:
        if way == 0.0:
            net = torque(state[0], level) - bias - hand * state[0]
            if abs(net) <= friction:
                out[done:] = state[0]
                return out
            way = float(np.sign(net))

        def rate(_: float, y: np.ndarray, level: int = level, way: float = way) -> list[float]:
            force = torque(y[0], level) - bias - hand * y[0] - damping * y[1] - friction * way
            return [y[1], force / inertia]

        low = level * q if counted else (-np.inf if level < 0 else 0.0)
        high = np.inf if level == 0 else (level + 1) * q if counted else 0.0
        stops = []
        for edge, direction in ((low, -1.0), (high, 1.0)):
            if np.isfinite(edge):
                stop = lambda _, y, edge=edge: y[0] - edge  # noqa: E731
                stop.terminal, stop.direction = True, direction
                stops.append(stop)
        turn = lambda _, y: y[1]  # noqa: E731
        turn.terminal, turn.direction = True, -way
        stops.append(turn)
        run = solve_ivp(
            rate,
            (t, times[-1] + 1e-4),
            state,
            method="DOP853",
            rtol=1e-12,
            atol=[1e-14, 1e-11],
            max_step=1e-4,
            events=stops,
            dense_output=True,
        )
        while done < len(times) and times[done] <= run.t[-1]:
            out[done] = run.sol(times[done])[0]
            done += 1
        t, state = float(run.t[-1]), [float(value) for value in run.y[:, -1]]
        fired = [i for i, at in enumerate(run.t_events) if len(at)]
        if not fired:
            break
        if fired[0] == len(stops) - 1:
            state[1], way = 0.0, 0.0
        else:
            down = stops[fired[0]].direction < 0.0
            state[0], level = (low, level - 1) if down else (high, level + 1)
            if abs(state[1]) < 1e-7:  # chatters within 1e-16 rad of the edge
                out[done:] = state[0]
                return out
    return out


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("knob", "hand", "encoder", "counts"),
    [
        ({}, {}, {}, 1024),
        ({"damping": 3.45e-4}, {}, {}, 1024),
        ({"damping": 3.45e-4}, {"stiffness": 0.04}, {}, 2048),
        ({"coulomb_torque": 1e-4}, {}, {}, 1024),
        ({"damping": 3.45e-4, "coulomb_torque": 3e-4}, {"stiffness": 0.04}, {}, 512),
        ({"damping": 3.45e-4}, {}, "none", 1),
        ({"damping": 1e-4, "coulomb_torque": 1e-4}, {"stiffness": 0.04}, "none", 1),
        ({"damping": 3e-3}, {"stiffness": 0.04}, "none", 1),
    ],
)
def test_angle(knob: dict[str, float], hand: dict[str, float], encoder: Any, counts: int) -> None:
    scene: dict[str, Any] = {
        "knob": {"inertia": 2.2e-6, **knob},
        "hand": hand,
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
        "encoder": encoder,
        "sampling": "continuous",
    }
    times = np.linspace(0.0, 0.06, 61)
    one = reduce_unsampled(SceneSpec.model_validate(scene).plain(), counts_per_rev=counts)
    motion = events(one, angle_rad=0.02, velocity_rad_s=-1.0, duration_s=0.07)
    assert len(motion.rows) > (1 if "damping" in knob and knob["damping"] > 1e-3 else 4)
    theta = motion.at(times)[0]
    assert np.max(np.abs(theta - solved(scene, counts, 0.02, -1.0, times))) <= WITHIN_RAD
