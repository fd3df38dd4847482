"""The motion of a simulated knob from sample to sample: its shortcuts against the engine's general way."""

import numpy as np
import pytest

from hknob_cli.engine.general.advance import advance_span
from hknob_cli.hardware import knob_motion
from hknob_cli.hardware.knob_motion import KnobMotion
from tests.hardware.trials import FRICTION, HAND


def path(monkeypatch: pytest.MonkeyPatch, *, friction: float, lag: float, patience: int = 10**9) -> np.ndarray:
    """Angle and speed under 300 random torques and pushes."""
    monkeypatch.setattr(knob_motion, "PATIENCE", patience)
    monkeypatch.setattr(KnobMotion, "_is_compiled", False)
    motion = KnobMotion(HAND._replace(coulomb_nm=friction), interval_s=1e-3, counts_per_rev=640_000, amplifier_s=lag)
    rng = np.random.default_rng(8)
    found = []
    for torque, push in zip(rng.choice([0.0, 2e-3], 300), rng.uniform(0.0, 1e-3, 300), strict=True):
        motion.move(float(torque), float(push))
        found.append((motion.angle_counts, motion.speed_rad_s))
    return np.array(found)


@pytest.mark.long
def test_compiled_goes_the_same_way_to_the_last_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = path(monkeypatch, friction=FRICTION, lag=5e-5)
    assert np.array_equal(path(monkeypatch, friction=FRICTION, lag=5e-5, patience=100), plain)
    assert KnobMotion._is_compiled


def test_without_friction_a_hold_is_one_product(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against halves of a hold by the general way: to rounding of 600 sums of some thousand counts."""
    whole = path(monkeypatch, friction=0.0, lag=5e-5)
    move = KnobMotion.move

    def halves(self: KnobMotion, torque_nm: float, push_nm: float) -> None:
        move(self, torque_nm, push_nm, 0.5)
        move(self, torque_nm, push_nm, 0.5)

    monkeypatch.setattr(KnobMotion, "move", halves)
    assert np.abs(path(monkeypatch, friction=0.0, lag=5e-5) - whole).max() < 1e-8


@pytest.mark.parametrize("friction", [0.0, FRICTION])
def test_a_short_lag_is_nearly_none(monkeypatch: pytest.MonkeyPatch, friction: float) -> None:
    """A lag of a microsecond delays a torque by as much: at most speed times that, over some time constants."""
    lag = 1e-6
    without = path(monkeypatch, friction=friction, lag=0.0)
    off = path(monkeypatch, friction=friction, lag=lag) - without
    fastest = np.abs(np.diff(without[:, 0])).max() / 1e-3
    assert np.abs(off[:, 0]).max() < 3 * fastest * lag
    assert off.any()


def test_the_engine_is_what_moves_it() -> None:
    """Any part of a period, as the engine's own `advance_span` does it, units apart."""
    motion = KnobMotion(HAND, interval_s=2e-3, counts_per_rev=1000)
    motion.move(1e-3, 4e-4, 0.3)
    motion.move(1e-3, 4e-4, 2.2)
    other = KnobMotion(HAND, interval_s=2e-3, counts_per_rev=1000)
    state = list(other._state)
    for part in (0.3, 1.0, 1.0, 0.2):
        advance_span(state, 6e-4 / other._unit_nm, part, other._body, other._pad)
    assert motion.angle_counts == pytest.approx(state[0], rel=1e-14)
