"""A controller made ready for a cell: torques under way, guards, what is proven, and the pieces of an interval."""

from typing import Any

import pytest

from hknob_cli.controllers.bounded_lag import BoundedLag
from hknob_cli.controllers.controller import Fading
from hknob_cli.controllers.scalar_law import LawKnob, make_law
from hknob_cli.engine.general.laws.law import LOOK, PIECE, SPAN, TORQUE
from hknob_cli.specs.scene import SceneSpec

LAG = {"kind": "bounded_lag", "time_constant": 0.02}
SENSED = {"kind": "velocity_damping", "damping": 2e-4, "velocity": "sensor"}
IMPULSE = {"kind": "impulse_damping", "pulse": 0.25, "detections": 4}


def made(controller: dict[str, Any] | None, **parts: Any) -> LawKnob:
    scene: dict[str, Any] = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
        **parts,
    }
    if controller:
        scene["controller"] = controller
    return make_law(SceneSpec.model_validate(scene).plain(), sample_rate_hz=1000.0, counts_per_rev=1024)


@pytest.mark.parametrize(("delay", "ages"), [(0.0, 1), (1.0, 2), (0.4, 2), (1.4, 3), (3.0, 4)])
def test_torques_of_so_many_samples_are_under_way(delay: float, ages: int) -> None:
    for controller, parts in ((LAG, 1), (IMPULSE, 2)):
        law = made(controller, actuator={"delay_samples": delay}).law
        assert (law.ages, law.parts) == (ages, parts)
        assert len(law.beside) == law.line + ages * parts


def test_what_outside_the_wall_changes_a_torque_is_watched() -> None:
    """Counts that a law tells apart, or that virtual damping acts on."""
    for controller, parts, watched in (
        (LAG, {}, 0.0),
        (SENSED, {}, 1.0),
        ({"kind": "half_sample"}, {}, 1.0),
        (LAG, {"wall": {"stiffness": 0.27, "damping": 1e-5}}, 1.0),
        (None, {}, 0.0),
        (None, {"wall": {"stiffness": 0.27, "damping": 1e-5}}, 1.0),
    ):
        assert made(controller, **parts).law.watch.damping == watched


def test_steps_and_dead_bands_guard_what_fades() -> None:
    """Each alone; not of a law in which nothing fades."""
    for controller, actuator, guarded in (
        (LAG, {}, False),
        (LAG, {"torque_step": 1e-5}, True),
        (LAG, {"dead_band": 1e-5}, True),
        ({"kind": "half_sample"}, {"torque_step": 1e-5}, False),
        ({"kind": "half_sample"}, {"dead_band": 1e-5}, False),
    ):
        law = made(controller, actuator=actuator).law
        assert law.guarded is guarded
        assert (law.weight > 0.0) is (controller is LAG)


def test_what_can_be_proven_of_a_law() -> None:
    """All that fades, however slowly; a sensed speed only beside neither friction nor hysteresis."""
    rubs = {"inertia": 1.9e-6, "coulomb_torque": 1e-7}
    for controller, parts, proven in (
        (LAG, {}, True),
        (LAG, {"knob": rubs}, True),
        (SENSED, {}, True),
        (SENSED, {"knob": rubs}, False),
        (SENSED, {"encoder": {"hysteresis_counts": 0.125}}, False),
        (LAG, {"encoder": {"hysteresis_counts": 0.125}}, True),
        (LAG, {"encoder": "none"}, False),
    ):
        assert made(controller, **parts).law.provable is proven
    assert 0.0 < made(SENSED, knob=rubs).knob.body.friction < 1.0
    assert made(LAG).law.fade > 0.9


def pieces_of(one: LawKnob) -> list[tuple[float, int, int]]:
    """Length, place of the torque from the first of the oldest sample's on, and look, of each piece."""
    law = one.law
    rows = [law.sched[k * PIECE : (k + 1) * PIECE] for k in range(law.pieces)]
    return [(row[SPAN], int(row[TORQUE]) - law.line, int(row[LOOK])) for row in rows]


def test_an_interval_is_cut_where_torques_change_and_looks_are() -> None:
    """A pulse of a quarter, and looks at each quarter; with a delay torques of the sample before go on."""
    looks = made(IMPULSE).law.rows + 1
    quarter = 0.25
    assert pieces_of(made(IMPULSE)) == [
        (quarter, 0, looks), (quarter, 1, looks + 1), (quarter, 1, looks + 2), (quarter, 1, -1)
    ]  # fmt: skip
    whole = pieces_of(made(IMPULSE, actuator={"delay_samples": 1.0}))
    assert whole == pieces_of(made(IMPULSE))  # the oldest act
    late = pieces_of(made(IMPULSE, actuator={"delay_samples": 0.125}))
    # Up to an eighth the rest of the sample before's, then this one's pulse for a quarter, then its rest.
    assert [(pytest.approx(span), torque, look) for span, torque, look in late] == [
        (0.125, 1, -1), (0.125, 2, looks), (0.125, 2, -1), (0.125, 3, looks + 1), (0.25, 3, looks + 2), (0.25, 3, -1)
    ]  # fmt: skip
    long = pieces_of(made(IMPULSE, actuator={"delay_samples": 0.875}))
    # The pulse of the sample before goes on to an eighth, its rest to seven; then this one's pulse.
    assert [(pytest.approx(span), torque, look) for span, torque, look in long] == [
        (0.125, 0, -1), (0.125, 1, looks), (0.25, 1, looks + 1), (0.25, 1, looks + 2), (0.125, 1, -1), (0.125, 2, -1)
    ]  # fmt: skip
    assert pieces_of(made(LAG)) == [(1.0, 0, -1)]
    assert pieces_of(made(LAG, actuator={"delay_samples": 1.0})) == [(1.0, 0, -1)]
    assert pieces_of(made(LAG, actuator={"delay_samples": 0.25})) == [(0.25, 0, -1), (0.75, 1, -1)]


def test_a_torque_that_ends_with_an_interval_leaves_no_piece_behind() -> None:
    """A delay of 1.9 samples and a pulse of 0.1: in doubles the two parts of a sample are a rounding short of 1."""
    assert (1.9 % 1.0) + 0.1 < 1.0
    one = made({"kind": "impulse_damping", "pulse": 0.1}, actuator={"delay_samples": 1.9})
    # The older rest goes on to 0.9, and there the next pulse begins; it fills the interval.
    assert [(pytest.approx(span), torque) for span, torque, _ in pieces_of(one)] == [(0.9, 1), (0.1, 2)]


def test_what_fades_weighs_as_the_wall_does() -> None:
    """In accelerations: of a knob twice as heavy, 2.2 and 4.4 with the hand, half as much."""
    light, heavy = made(LAG).law, made(LAG, knob={"inertia": 4.1e-6}).law
    assert light.weight == pytest.approx(2.0 * heavy.weight, rel=1e-12)
    assert light.unit == pytest.approx(0.27 * 1e-6 / 2.2e-6, rel=1e-12)


def test_nothing_is_proven_of_a_sensed_speed_beside_cogging() -> None:
    cogging = {"torque": 1e-5, "per_revolution": 12}
    assert made(SENSED, cogging=cogging).knob.body.cogs is not None
    assert not made(SENSED, cogging=cogging).law.provable
    assert made(LAG, cogging=cogging).law.provable


def test_nothing_is_proven_of_what_does_not_fade(monkeypatch: pytest.MonkeyPatch) -> None:
    for fade, proven in ((1.0, False), (1.0 - 2.0**-50, True)):
        monkeypatch.setattr(BoundedLag, "fading", lambda *_, fade=fade: Fading(0, fade, 1.0))
        assert made(LAG).law.provable is proven
