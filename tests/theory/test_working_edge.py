"""The working edge, against the sampled loop of the engine and the rest condition."""

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.engine.loop import drive_of, upper_edge
from hknob_cli.scene.sampled_knob import sample_knob
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Hand, Knob, Scene, Wall
from hknob_cli.theory.working_edge import WorkingEdge, working_edge


def scene(*, push: float, stiffness: float = 0.04, rounding: str = "floor", offset: float = 0.0) -> Scene:
    return Scene(
        Knob(1.9e-6),
        Wall(0.27),
        Hand(3e-7, 3.45e-4, stiffness),
        Bias(torque=push),
        Encoder(rounding, offset),
        Actuator(delay_samples=0.5),
    )


def at(found: Scene, counts: int = 1024) -> WorkingEdge:
    return working_edge(found, {"sample_rate_hz": 1000.0, "counts_per_rev": counts})


@given(
    push=st.floats(1e-5, 2e-2),
    stiffness=st.sampled_from([0.0, 0.04, 0.3]),
    rounding=st.sampled_from(["floor", "nearest", "ceil", "truncate"]),
    offset=st.sampled_from([0.0, 0.25, 0.9]),
)
def test_it_is_where_the_engine_s_wall_overcomes_the_push(push, stiffness, rounding, offset) -> None:
    found = scene(push=push, stiffness=stiffness, rounding=rounding, offset=offset)
    edge = at(found)
    loop = sample_knob(found, sample_rate_hz=1000.0, counts_per_rev=1024).loop
    for level in range(0, -100, -1):  # from outside inwards, until the torque just inside the edge carries the push
        x = upper_edge(float(level - 1), loop.sense)
        outside, inside = (drive_of(float(at), loop) - loop.beta * x for at in (level, level - 1))
        if inside >= 0.0:
            break
    scale = loop.kappa / (0.27 * edge.quantum_rad)
    assert edge.torque_step * scale == pytest.approx(inside - outside, rel=1e-9)
    assert edge.balance == pytest.approx(-outside / (inside - outside), abs=1e-9)


@given(push=st.floats(1e-5, 1e-2), counts=st.integers(100, 9000), stiffness=st.floats(0.001, 0.5))
def test_it_balances_between_counts_unless_a_rest_point_exists(push: float, counts: int, stiffness: float) -> None:
    """A rest point exists iff g / ((K + k) q) lies in (m - k / (K + k), m] for a whole m >= 1."""
    part = push / ((0.27 + stiffness) * 2.0 * pi / counts)
    share = stiffness / (0.27 + stiffness)
    below = -(-part // 1) - part  # how far the next whole number is
    if min(below, abs(below - share)) < 1e-9:
        return
    assert (0.0 < at(scene(push=push, stiffness=stiffness), counts).balance < 1.0) == (below > share)


def test_half_a_quantum_is_half_a_torque_step() -> None:
    found = scene(push=0.0)._replace(bias=Bias(half_quantum=True))
    edge = at(found)
    assert edge.balance == 0.5
    assert edge.delay_s == pytest.approx(1e-3)  # half a period, and half a period of transport delay
