"""The closed laws, against quadrature of their waveform, the exact phase condition, and printed figures.

The working edge, against the sampled loop of the engine and the rest condition.
"""

from math import atan2, isclose, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from hknob_cli.engine.loop import drive_of, upper_edge
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Hand, Knob, Scene, Wall
from hknob_cli.theory import laws
from hknob_cli.theory.laws import WorkingEdge, working_edge


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


def edge(**changes: float) -> WorkingEdge:
    """Table 7's plant, lightest grip, at 1 kHz and 1024 counts; all damping is the knob's unless told otherwise."""
    period = changes.pop("period_s", 1e-3)
    values = {
        "inertia": 2.2e-6,
        "damping": 3.45e-4,
        "hand_stiffness": 0.04,
        "wall_stiffness": 0.27,
        "wall_damping": 0.0,
        "coulomb_torque": 0.0,
        "quantum_rad": 2.0 * pi / 1024,
        "transport_s": 0.0,
        "balance": 0.5,
        **changes,
    }
    values.setdefault("knob_damping", values["damping"])
    step = values.pop("torque_step", values["wall_stiffness"] * values["quantum_rad"])
    return WorkingEdge(period_s=period, torque_step=step, **values)


# A heavy dial, a light pinch knob, a steering wheel, and a scene with delay: none is in the dissertation.
PLANTS = {
    "dissertation": edge(),
    "dial": edge(inertia=3e-5, damping=2e-3, hand_stiffness=0.1, wall_stiffness=1.5, quantum_rad=2 * pi / 4000),
    "pinch": edge(inertia=4e-7, damping=9e-5, hand_stiffness=0.01, wall_stiffness=0.05, quantum_rad=2 * pi / 600),
    "wheel": edge(inertia=0.05, damping=0.8, hand_stiffness=6.0, wall_stiffness=150.0, quantum_rad=2 * pi / 10000),
    "delayed": edge(period_s=2e-4, transport_s=3e-4),
}


def exact_omega(plant: WorkingEdge) -> float:
    """Where plant and delay turn the phase by half a turn."""
    j, b, k, d = plant.inertia, plant.damping, plant.hand_stiffness, plant.delay_s
    low = sqrt(k / j)
    return brentq(lambda w: atan2(b * w, k - j * w * w) + w * d - pi, low, low + pi / d, xtol=1e-13, rtol=1e-14)


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_describing_function_is_the_limit_of_the_exact_phase_condition(plant: WorkingEdge) -> None:
    """With an error of (w D)^2 / 6, which the next order removes."""
    for shorter in (10.0, 100.0, 1000.0):
        short = plant._replace(period_s=plant.period_s / shorter, transport_s=plant.transport_s / shorter)
        found = laws.describing_function(short)
        omega = exact_omega(short)
        gain = 1.0 / abs(complex(short.hand_stiffness - short.inertia * omega**2, short.damping * omega))
        p2p = 2.0 * (4.0 / pi) * (0.5 * short.wall_stiffness * short.quantum_rad) * gain
        small = (omega * short.delay_s) ** 2
        share = 1.0 - short.hand_stiffness / (short.inertia * omega**2)  # of the spring, which feels no delay
        assert 2.0 * pi * found.frequency_hz / omega - 1.0 == pytest.approx(small * share / 6.0, rel=small, abs=1e-9)
        assert found.p2p_rad / p2p - 1.0 == pytest.approx(small / 6.0, rel=small, abs=1e-9)


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
@pytest.mark.parametrize("friction", [0.0, 0.03, 0.1])
def test_energy_balance_by_quadrature(plant: WorkingEdge, friction: float) -> None:
    """Velocity is triangular; each late switching costs the torque step over the way made in the delay."""
    step = plant.wall_stiffness * plant.quantum_rad
    plant = plant._replace(coulomb_torque=friction * step)
    slope = step / (2.0 * plant.inertia)

    def velocity(t: float, period: float) -> float:
        return slope * (0.25 * period - abs(t - 0.25 * period))  # of the half cycle in which it is positive

    def excess(period: float) -> float:
        taken, _ = quad(
            lambda t: plant.damping * velocity(t, period) ** 2 + plant.coulomb_torque * velocity(t, period),
            0.0,
            0.5 * period,
            points=[0.25 * period],
        )
        return taken / (step * plant.delay_s * velocity(0.25 * period, period)) - 1.0

    guess = sqrt(24.0 * plant.inertia * 2.0 * plant.delay_s / plant.damping)
    period = brentq(excess, 1e-3 * guess, 2.0 * guess, xtol=1e-18, rtol=1e-13)
    p2p, _ = quad(velocity, 0.0, 0.5 * period, args=(period,), points=[0.25 * period])
    found = laws.energy_balance(plant)
    assert found.frequency_hz == pytest.approx(1.0 / period, rel=1e-9)
    assert found.p2p_rad == pytest.approx(p2p, rel=1e-9)


def test_figures_of_the_dissertation() -> None:
    plant = edge()
    scale = plant.quantum_rad * plant.period_s
    assert laws.quantum_period(plant).p2p_rad / scale == pytest.approx(498.2, abs=0.1)  # printed: C = 500
    assert laws.describing_function(plant) == laws.quantum_period(plant)
    balance = laws.energy_balance(plant)
    assert balance.p2p_rad / scale == pytest.approx(587.0, abs=0.1)
    assert balance.frequency_hz == pytest.approx(80.8, abs=0.05)  # printed: approximately 80 Hz
    assert balance.in_domain
    given = laws.quantum_period(plant, constant=500.0)
    assert given.p2p_rad == 500.0 * scale
    assert given.frequency_hz is None
    assert given.in_domain


def test_root_mean_square_of_parabolic_arcs() -> None:
    """Of peak to peak 1: an arc from the edge to the peak and back, the other half being its mirror image."""
    square, _ = quad(lambda u: (0.5 * (1.0 - u * u)) ** 2, -1.0, 1.0)
    assert sqrt(square / 2.0) == pytest.approx(laws.RMS_ARCS, rel=1e-12)
    assert pytest.approx(1.0 / sqrt(8.0), rel=2e-4) == laws.RMS_SINE


STEP = 0.27 * 2.0 * pi / 1024
REASONS = {
    "the wall has no stiffness": {"wall_stiffness": 0.0},
    "there is no viscous damping": {"damping": 0.0},
    "friction holds the knob": {"coulomb_torque": 0.5 * STEP},
    "the push is carried at rest": {"balance": 1.1},
    "the law knows no virtual damping": {"wall_damping": 1e-4},
    "the torque step at the wall's edge is not one count": {"torque_step": 0.5 * STEP},
    "the motion spans more than the counts beside one edge": {"period_s": 5e-3},
    "the delay is not short against a cycle": {"inertia": 2e-7},
    "the push is far from half a torque step": {"balance": 0.1},
    "friction is not small against a torque step": {"coulomb_torque": 0.2 * STEP},
}


@pytest.mark.parametrize("law", [laws.quantum_period, laws.describing_function, laws.energy_balance])
@pytest.mark.parametrize(("reason", "changes"), REASONS.items(), ids=REASONS)
def test_a_law_says_why_it_is_out_of_its_domain(law, reason: str, changes: dict[str, float]) -> None:
    found = law(edge(**changes))
    assert (found.in_domain, found.reason) == (False, reason)


def test_what_a_law_does_not_know() -> None:
    little = edge(coulomb_torque=0.1 * STEP)
    assert laws.describing_function(little).reason == "the law knows no friction"
    assert laws.energy_balance(little).in_domain
    stiff = edge(hand_stiffness=0.3)
    assert laws.describing_function(stiff).in_domain
    assert laws.energy_balance(stiff).reason == "the law knows no hand stiffness"


def test_friction_raises_the_pitch_shrinks_the_motion_and_ends_it() -> None:
    found = [laws.energy_balance(edge(coulomb_torque=part * STEP)) for part in (0.0, 0.05, 0.1, 0.3, 0.49, 0.5)]
    sizes = [one.p2p_rad for one in found]
    pitches = [one.frequency_hz for one in found]
    assert sizes == sorted(sizes, reverse=True)
    assert pitches[:-1] == sorted(pitches[:-1])
    assert (sizes[-1], pitches[-1]) == (0.0, 0.0)


def test_friction_alone_bounds_the_motion_too() -> None:
    """Without damping, T_c P / 8 = K q D / 2."""
    found = laws.energy_balance(edge(damping=0.0, coulomb_torque=0.1 * STEP))
    assert isclose(1.0 / found.frequency_hz, 4.0 * STEP * 0.5e-3 / (0.1 * STEP))
    assert not found.in_domain
