"""Parts of a trial by hand: what a controller is told of knob and hand, what sensors told, and how long all took."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from hknob_cli.hardware import serial_device
from hknob_cli.hardware.control import control_of
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.order import _model_of
from hknob_cli.hardware.person import hand_at
from hknob_cli.hardware.port import Converters, Torque
from hknob_cli.hardware.tables import _settled_s
from hknob_cli.hardware.trial_file import _sensed
from hknob_cli.hardware.virtual import NOTHING, VirtualLoop
from hknob_cli.hardware.wire.answers import Samples
from hknob_cli.hardware.wire.messages import encode, is_finite
from hknob_cli.specs.controller import Controller
from tests.hardware.campaigns import planned
from tests.hardware.fake_target import made_up
from tests.hardware.test_session import Kind, Wire
from tests.hardware.trials import HAND, settings


def test_a_controller_knows_where_counts_lie() -> None:
    """A damper's first number; without converters at their angle."""
    damper = Controller("velocity_damping", damping=1e-4)
    for converters, offset in ((Converters(offset_counts=0.375), 0.375), (None, 0.0)):
        assert control_of(damper, settings()._replace(converters=converters)).numbers[0] == offset


def test_a_model_has_the_damping_of_knob_and_hand() -> None:
    plan = planned()
    plan = plan._replace(knob=plan.knob._replace(damping=2e-4))
    grip = plan.course.grip_target_n
    assert grip
    hand, model = hand_at(grip), _model_of(plan, Controller("half_sample"))
    assert model.damping == pytest.approx(hand.damping + 2e-4, rel=1e-14)
    assert model.inertia == pytest.approx(hand.inertia + plan.knob.inertia, rel=1e-14)
    assert model.stiffness == hand.stiffness


def test_what_a_sensor_told_is_whole_or_nothing() -> None:
    one, other = np.array([1.0, 2.0]), np.array([3.0])
    assert _sensed([one, None]) is None
    assert _sensed([None]) is None
    assert _sensed([]) is None
    both = _sensed([one, other])
    assert both is not None
    assert both.tolist() == [1.0, 2.0, 3.0]


def test_a_grip_is_held_so_long_after_the_start() -> None:
    """Samples from the first with the wall on, over their rate."""
    table = pa.table({"sample": [7, 8, 9, 10], "running": [False, True, True, True]})
    trial: Any = SimpleNamespace(sample_rate_hz=2000.0)
    one: Any = SimpleNamespace(settled_sample=508, table=table, trial=trial)
    assert _settled_s(one) == 0.25
    one.settled_sample = None
    assert _settled_s(one) is None


def test_a_speed_is_over_a_period_at_least(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also that of a sample which follows at once on a late one."""
    told = settings(block_samples=5)
    loop = VirtualLoop(told, simulated=HAND, nuisances=Nuisances(), native_counts=640_000)
    begins = np.array([0.0, 1.75, 2.0, 3.0, 4.5])
    monkeypatch.setattr(loop._disturbances, "begins", lambda count: (begins, np.zeros(count)))
    passed: list[float] = []

    def sample(_index: int, _position: float, passed_s: float, _running: bool) -> Any:
        passed.append(passed_s)
        return 0, NOTHING

    monkeypatch.setattr(loop, "_sample", sample)
    loop.block(running=True)
    assert passed == pytest.approx([one * told.interval_s for one in (1.0, 1.75, 1.0, 1.0, 1.5)])


def test_every_float_of_a_block_is_a_number() -> None:
    """The torques and the grip force, each."""
    fine = made_up(0, 4, 1000.0, started=None)
    assert is_finite(Samples(1, 2, 3, fine))
    for name in ("torque_nm", "grip_n"):
        for bad in (np.nan, np.inf):
            values = getattr(fine, name).copy()
            values[2] = bad
            message = Samples(1, 2, 3, fine._replace(**{name: values}))
            assert not is_finite(message)
            with pytest.raises(ValueError, match="not a finite number"):
                encode(message)


@pytest.mark.parametrize("torque", [False, True])
def test_a_target_may_go_on_sampling_after_a_stop_without_a_torque(torque: bool) -> None:
    """Of what it made after it had said that it was done."""
    wire = Wire()
    wire.arm()
    wire.do(Kind.START)
    wire.go(0.1)
    made = wire.target.blocks[-1]
    wire.do(Kind.STOP)
    wire.go(0.1)
    block = made.samples._replace(running=made.samples.running & torque, torque_nm=made.samples.torque_nm * torque)
    later = made._replace(block=len(wire.target.blocks) + 3, samples=block)
    wire.session.feed(wire.target._send(later), now=wire.now)
    said = "the target acknowledged STOP, but goes on sampling with the wall on"
    assert wire.session.failure == (said if torque else None)


def test_a_torque_that_goes_off_at_last_is_not_said_to_be_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is said once a second while it is on: not by the RELEASE that takes it off, a second after the last word."""
    now, said, asked = [100.0], [0.0] * 0, [0]

    def sleep(_seconds: float) -> None:
        now[0] += 0.5

    monkeypatch.setattr(serial_device, "time", SimpleNamespace(monotonic=lambda: now[0], sleep=sleep))
    one = serial_device.SerialDevice("somewhere")
    one._torque = Torque.ON

    def release(_pump: Any) -> str:
        asked[0] += 1
        one._torque = Torque.OFF if asked[0] == 5 else Torque.ON
        return "" if asked[0] == 5 else "it shows a torque"

    monkeypatch.setattr(one, "_release", release)
    monkeypatch.setattr(one, "_alarm", lambda _text: said.append(now[0]))
    pump: Any = SimpleNamespace(broken=None)
    one._insist(pump)
    assert (asked, said) == ([5], [101.0])
