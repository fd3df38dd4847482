"""Messages: as the golden frames say, back and forth, and nothing that is not one."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.hardware.port import Block, Control, Settings
from hknob_cli.hardware.wire.answers import Samples, most_samples
from hknob_cli.hardware.wire.codes import Kind
from hknob_cli.hardware.wire.commands import Configure, Plain, SetAct, Simulate
from hknob_cli.hardware.wire.messages import Decoder, decode, encode, frame
from tests.conftest import ROOT
from tests.hardware.golden import BOOT, GOLDEN, LAG, SETTINGS, SIMULATED, WITH_SINES, block, text

BODY_MOST = 1024
FILE = ROOT / "data" / "wire" / "golden_frames.txt"
LINES = [line.split(" | ") for line in FILE.read_text().splitlines() if not line.startswith("#")]


def same(one: object, other: object) -> bool:
    """Equality of messages, whose blocks hold arrays."""
    if isinstance(one, Samples) and isinstance(other, Samples):
        columns = zip(one.samples, other.samples, strict=True)
        return one[:3] == other[:3] and all(np.array_equal(a, b) for a, b in columns)
    return type(one) is type(other) and one == other


def test_the_file_of_golden_frames_is_what_the_encoder_makes() -> None:
    assert FILE.read_text() == text()


@pytest.mark.parametrize(("name", "frame_hex"), [(line[0], line[2]) for line in LINES])
def test_golden_frames_say_their_fields(name: str, frame_hex: str) -> None:
    (body,) = Decoder().feed(bytes.fromhex(frame_hex))
    assert same(decode(body), GOLDEN[name])


def test_every_type_has_a_golden_frame() -> None:
    assert {message.kind for message in GOLDEN.values()} == set(Kind)


@pytest.mark.parametrize("name", GOLDEN)
def test_no_other_length_is_taken(name: str) -> None:
    body = encode(GOLDEN[name])
    assert all(decode(body[:length]) is None for length in range(len(body)))
    assert decode(body + b"\0") is None


@pytest.mark.parametrize("name", GOLDEN)
def test_no_other_version_or_type_is_taken(name: str) -> None:
    body = encode(GOLDEN[name])
    assert decode(b"\2" + body[1:]) is None
    assert decode(bytes((1, 0x7F)) + body[2:]) is None


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_floats_that_are_sent_must_be_numbers_and_of_those_that_come_it_can_be_said_which_is_not(bad: float) -> None:
    with pytest.raises(ValueError, match="finite"):
        encode(Configure(1, SETTINGS._replace(wall_stiffness=bad)))
    with pytest.raises(ValueError, match="finite"):
        encode(Simulate(1, SIMULATED._replace(push_nm=bad)))
    for values in ({"numbers": (0.0, bad)}, {"rows": (bad,)}):
        with pytest.raises(ValueError, match="finite"):
            encode(SetAct(1, LAG._replace(**values)))
    body = bytearray(encode(GOLDEN["block_of_2"]))
    for offset in (8, 12):  # torque and grip of the first sample
        spoilt = bytearray(body)
        spoilt[23 + offset : 27 + offset] = struct.pack("<f", bad)
        assert np.isfinite(decode(bytes(spoilt)).samples.torque_nm[0]) == (offset == 12)
    spoilt = bytearray(body)
    spoilt[31:35] = bytes.fromhex("0100807f")  # a NaN that signals, which numpy would warn of
    assert np.isnan(decode(bytes(spoilt)).samples.torque_nm[0])
    body = bytearray(encode(GOLDEN["ack_of_simulate"]))
    body[-8:] = struct.pack("<d", bad)
    assert not math.isfinite(decode(bytes(body)).said.grip_sines[0].phase)
    body = bytearray(encode(GOLDEN["simulate"]))
    body[6:14] = struct.pack("<d", bad)
    assert decode(bytes(body)) is None


@pytest.mark.parametrize("values", [{"period_ns": 2**32}, {"block_samples": -1}, {"watchdog_us": 0.5}])
def test_what_does_not_fit_its_field_is_named_so(values: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="fit"):
        encode(Configure(1, SETTINGS._replace(**values)))  # type: ignore[arg-type]


def test_five_sines_are_one_too_many() -> None:
    with pytest.raises(ValueError, match="at most 4"):
        encode(Simulate(1, WITH_SINES._replace(push_sines=WITH_SINES.grip_sines * 5)))


def test_the_largest_frame_has_the_bytes_that_the_page_of_the_wire_says() -> None:
    body = encode(Samples(BOOT, 1, 0, block(48)))
    assert len(body) == 839
    assert 845 <= len(frame(body)) <= 848


@settings(deadline=None)
@given(st.binary(max_size=1024))
def test_any_bytes_decode_to_a_message_that_encodes_to_them_or_to_nothing(body: bytes) -> None:
    message = decode(body)
    assert message is None or same(decode(encode(message)), message)


u32 = st.integers(0, 2**32 - 1)
finite = st.floats(allow_nan=False, allow_infinity=False)


@settings(deadline=None)
@given(
    u32,
    st.builds(
        Settings,
        *(u32, u32, finite, finite, finite, finite, u32, st.integers(0, 2**16 - 1)),
        control=st.none(),
        pulse=st.none(),
        over_angle=st.none(),
        converters=st.none(),
    ),
)
def test_settings_come_back_bit_by_bit(nonce: int, settings: Settings) -> None:
    body = encode(Configure(nonce, settings))
    assert decode(body) == Configure(nonce, settings)
    back = decode(body)
    assert back is not None
    assert encode(back) == body


@settings(deadline=None)
@given(u32, st.builds(Control, st.integers(0, 255), st.integers(0, 255), st.tuples(finite, finite), st.tuples(finite)))
def test_controllers_come_back_bit_by_bit(nonce: int, control: Control) -> None:
    body = encode(SetAct(nonce, control))
    back = decode(body)
    assert back == SetAct(nonce, control)
    assert encode(back) == body


@settings(deadline=None)
@given(u32, st.sampled_from([Kind.HELLO, Kind.ARM, Kind.START, Kind.STOP, Kind.RELEASE]))
def test_plain_commands_come_back(nonce: int, kind: Kind) -> None:
    assert decode(encode(Plain(kind, nonce))) == Plain(kind, nonce)


@settings(deadline=None)
@given(u32, u32, st.integers(1, 48), st.data())
def test_blocks_come_back(first: int, overruns: int, count: int, data: st.DataObject) -> None:
    def column(of: st.SearchStrategy[float], kind: type) -> np.ndarray:
        return np.array(data.draw(st.lists(of, min_size=count, max_size=count)), kind)

    floats = st.floats(width=32, allow_nan=False, allow_infinity=False)
    angles = column(st.integers(-(2**31), 2**31 - 1), np.int64)
    columns = (column(u32, np.int64), angles, column(floats, float), column(floats, float), column(st.booleans(), bool))
    message = Samples(BOOT, 5, 3, Block(first, *columns, overruns))
    assert same(decode(encode(message)), message)


@settings(deadline=None)
@given(st.integers(1, 63), st.data())
def test_readings_come_back(looks: int, data: st.DataObject) -> None:
    count = data.draw(st.integers(1, most_samples(looks)))
    angles = st.lists(st.integers(-(2**31), 2**31 - 1), min_size=looks, max_size=looks)
    read = np.array(data.draw(st.lists(angles, min_size=count, max_size=count)), np.int64)
    message = Samples(BOOT, 5, 3, block(count)._replace(looks=read))
    assert message.kind is Kind.READINGS
    body = encode(message)
    assert len(body) <= BODY_MOST
    back = decode(body)
    assert same(back, message)
    spoilt = bytearray(body)
    spoilt[23] = 0  # no readings: that is another message
    assert decode(bytes(spoilt)) is None
