"""Stiff, tiny, huge and degenerate scenes: each ends in a stated outcome, in bounded time, without a NaN or a warning.

The outcome itself is checked where physics says what it must be; the rest must be decided, or say why not.
"""

from math import isfinite, pi

import pytest

from hknob_cli.engine.outcome import Outcome
from hknob_cli.errors import ComputationError
from hknob_cli.measure.orbit import OrbitMeasures
from hknob_cli.specs.load import validate
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.run import SweepStage

ANY = {"cycle", "rest", "diverged", "undecided"}
CYCLE, REST, DIVERGED, UNDECIDED = {"cycle"}, {"rest"}, {"diverged"}, {"undecided"}


def scene(
    *,
    rate=1000.0,
    counts=1024,
    wall=0.27,
    k=0.04,
    b=3.45e-4,
    inertia=2.2e-6,
    bias=0.001,
    angle=0.02,
    velocity=0.0,
    encoder=None,
    actuator=None,
    phases=3,
):
    """Spec values of one cell."""
    parts = {
        "knob": {"inertia": inertia},
        "hand": {"damping": b, "stiffness": k},
        "wall": {"stiffness": wall},
        "bias": {"half_quantum": True} if bias == "half" else {"torque": bias},
    }
    if encoder:
        parts["encoder"] = encoder
    if actuator:
        parts["actuator"] = actuator
    return {
        "kind": "sweep",
        "name": "extreme",
        "scene": parts,
        "grid": {"sample_rate_hz": rate, "counts_per_rev": counts},
        "starts": {"angle": angle, "velocity": velocity, "phases": phases},
    }


QUANTUM = 2 * pi / 1024

SCENES = {
    # sample rate
    "rate 1 Hz": (scene(rate=1.0), ANY),
    "rate 1 Hz, half quantum": (scene(rate=1.0, bias="half"), ANY),
    "rate 10 Hz": (scene(rate=10.0), ANY),
    "rate 100 kHz": (scene(rate=1e5), CYCLE),
    "rate 1 MHz": (scene(rate=1e6, phases=2), CYCLE),
    "rate 10 MHz": (scene(rate=1e7, phases=1), ANY),
    "rate 10 MHz, half quantum": (scene(rate=1e7, bias="half", phases=1), ANY),
    # encoder
    "1 count": (scene(counts=1), ANY),
    "2 counts": (scene(counts=2), ANY),
    "3 counts, half quantum": (scene(counts=3, bias="half"), ANY),
    "65536 counts": (scene(counts=65536), ANY),
    "2^24 counts": (scene(counts=2**24), ANY),
    "2^31 counts": (scene(counts=2**31), ANY),
    "2^31 counts, half quantum": (scene(counts=2**31, bias="half"), ANY),
    "2^31 counts at 10 kHz": (scene(counts=2**31, rate=1e4), ANY),
    "1 count at 10 kHz": (scene(counts=1, rate=1e4), ANY),
    # wall
    "no wall": (scene(wall=0.0), REST),
    "no wall, no bias": (scene(wall=0.0, bias=0.0), REST),
    "soft wall": (scene(wall=1e-9), REST),
    "wall 1e3": (scene(wall=1e3), ANY),
    "wall 1e6": (scene(wall=1e6), ANY),
    "wall 1e6, 1e6 Hz": (scene(wall=1e6, rate=1e6), ANY),
    "wall 1e6, 1e7 Hz, 2^20 counts": (scene(wall=1e6, rate=1e7, counts=2**20, phases=1), ANY),
    # hand
    "no damping": (scene(b=0.0), UNDECIDED | DIVERGED),
    "no hand stiffness": (scene(k=0.0), ANY),
    "no hand stiffness, half quantum": (scene(k=0.0, bias="half"), CYCLE | UNDECIDED),
    "no hand stiffness, half quantum, 10 kHz": (scene(k=0.0, bias="half", rate=1e4), CYCLE | UNDECIDED),
    "bouncing ball": (scene(k=0.0, b=0.0), UNDECIDED | DIVERGED),
    "nobody holds it": (scene(k=0.0, b=0.0, bias=0.0), REST),
    "nobody holds it, moving out": (scene(k=0.0, b=0.0, bias=0.0, velocity=1.0), DIVERGED),
    "nobody holds it, moving in": (scene(k=0.0, b=0.0, bias=0.0, velocity=-1.0), DIVERGED),
    "nobody holds it, damped": (scene(k=0.0, bias=0.0, velocity=-1.0), REST),
    "pushed with no wall and no hand": (scene(k=0.0, wall=0.0), DIVERGED),
    "undamped, free ringing": (scene(b=0.0, bias=0.0, wall=0.0), UNDECIDED),
    "hand 1e6 stiff": (scene(k=1e6), ANY),
    "damping ratio 1e-8": (scene(b=2e-8 * (0.04 * 2.2e-6) ** 0.5), ANY),
    "damping ratio 1e-3": (scene(b=2e-3 * (0.04 * 2.2e-6) ** 0.5), ANY),
    "overdamped by 1e3": (scene(b=2e3 * (0.04 * 2.2e-6) ** 0.5), ANY),
    "overdamped by 1e6": (scene(b=2e6 * (0.04 * 2.2e-6) ** 0.5), ANY),
    "overdamped by 1e6, half quantum": (scene(b=2e6 * (0.04 * 2.2e-6) ** 0.5, bias="half"), ANY),
    "critically damped": (scene(b=2.0 * (0.04 * 2.2e-6) ** 0.5), ANY),
    # inertia
    "inertia 1e-12": (scene(inertia=1e-12), ANY),
    "inertia 1e-12, no damping": (scene(inertia=1e-12, b=0.0), ANY),
    "inertia 1e-12, half quantum": (scene(inertia=1e-12, bias="half"), ANY),
    "inertia 1e-9, 1 MHz": (scene(inertia=1e-9, rate=1e6, phases=1), ANY),
    "inertia 1": (scene(inertia=1.0), ANY),
    "inertia 1, half quantum, 100 Hz": (scene(inertia=1.0, bias="half", rate=100.0), ANY),
    # bias
    "no bias": (scene(bias=0.0), CYCLE),
    "no bias, overdamped": (scene(bias=0.0, b=0.1), REST),
    "bias 1e-12": (scene(bias=1e-12), ANY),
    "bias 1": (scene(bias=1.0), ANY),
    "bias 1e6": (scene(bias=1e6), ANY),
    "bias 1e9, 2^31 counts": (scene(bias=1e9, counts=2**31), UNDECIDED),
    # samples on an edge
    "start on the wall's edge": (scene(angle=0.0), CYCLE),
    "start at rest on the wall's edge, no bias": (scene(angle=0.0, bias=0.0), REST),
    "start on a count edge inside": (scene(angle=-QUANTUM), CYCLE),
    "held on a count edge, undamped, no bias": (
        scene(angle=-2 * QUANTUM, bias=0.0, k=0.0, b=0.0),
        DIVERGED | UNDECIDED,
    ),
    "rest point on a count edge": (scene(bias=(0.27 + 0.04) * QUANTUM, angle=-QUANTUM), ANY),
    "rest point on a count edge, overdamped": (scene(bias=(0.27 + 0.04) * QUANTUM, angle=-QUANTUM, b=0.1), ANY),
    "one sample a cycle, undamped": (scene(b=0.0, k=2.2e-6 * (2 * pi * 1000) ** 2), UNDECIDED | DIVERGED),
    # sensor and actuator
    "nearest": (scene(encoder={"rounding": "nearest"}), ANY),
    "ceil": (scene(encoder={"rounding": "ceil"}), ANY),
    "truncate": (scene(encoder={"rounding": "truncate"}), ANY),
    "offset 0.999999": (scene(encoder={"offset_counts": 0.999999}), ANY),
    "delay 0.5": (scene(actuator={"delay_samples": 0.5}), ANY),
    "delay 7.3": (scene(actuator={"delay_samples": 7.3}), ANY),
    "delay 100": (scene(actuator={"delay_samples": 100.0}), ANY),
    # combined
    "stiff wall, no inertia, slow": (scene(wall=1e6, inertia=1e-12, rate=1.0), ANY),
    "stiff wall, heavy, fast, 1 count": (scene(wall=1e6, inertia=1.0, rate=1e6, counts=1, phases=1), ANY),
    "a hand that rings 1e8 times in an interval": (scene(k=1e12, rate=1.0, phases=1), UNDECIDED),
    "everything small": (scene(wall=1e-12, inertia=1e-12, b=1e-15, k=1e-12, bias=1e-15), ANY),
    "everything large": (scene(wall=1e6, inertia=1.0, b=1e6, k=1e6, bias=1e6, rate=1e7, phases=1), ANY),
    "overdamped, stiff, delayed": (scene(wall=1e6, b=1e3, actuator={"delay_samples": 3.5}), ANY),
    "fast start": (scene(velocity=-1e6), ANY),
    "far start": (scene(angle=1e3), ANY),
    "deep start": (scene(angle=-1e3), ANY),
}


@pytest.mark.parametrize(
    "part",
    [
        {"knob": {"inertia": 1.9e-6, "coulomb_torque": 1e-4}, "hand": {"stiffness": 1e12}},
        {"hand": {"finger": {"inertia": 1e-9, "stiffness": 1e9}, "fingerpad": {"stiffness": 1e9}}},
        {"hand": {"stiffness": 1e12}, "encoder": "none"},
    ],
)
def test_what_rings_too_often_to_be_followed_is_told(part: dict) -> None:
    """Each turn is an event where there is friction, a finger, or a sensor without counts."""
    values = scene(rate=1.0)
    values["scene"] |= part
    if part.get("encoder") == "none":
        del values["grid"]["counts_per_rev"]
    source = Source("extreme")
    source.value = values
    with pytest.raises(
        ComputationError, match=r"at 1 Hz the scene cannot be followed: it rings to and fro .*e\+0[78] "
    ):
        SweepStage(validate(source), jobs=1).run()


@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", SCENES)
def test_ends_in_a_stated_outcome(name: str) -> None:
    values, allowed = SCENES[name]
    source = Source("extreme")
    source.value = values
    result = SweepStage(validate(source), jobs=1).run()
    rows = result.orbits.to_pylist()
    assert sum(row["basin_fraction"] for row in rows) == pytest.approx(1.0, abs=1e-12)
    for row in rows:
        assert row["outcome"] in allowed
        assert row["certified"] == (row["reason"] == "")
        if row["outcome"] in ("undecided", "diverged"):
            assert row["reason"] != ""
        if row["outcome"] == "rest":
            assert row["p2p_rad"] == row["rms_rad"] == row["frequency_hz"] == 0.0
        for value in row.values():
            assert not isinstance(value, float) or isfinite(value)
        if row["outcome"] == "cycle":
            assert row["p2p_rad"] > 0.0
            assert row["max_rad"] > row["min_rad"]
            assert row["frequency_hz"] > 0.0
            if row["certified"]:
                assert row["wall_work_j"] == pytest.approx(row["damping_loss_j"], rel=1e-6)


def test_table_is_as_long_as_promised() -> None:
    assert len(SCENES) >= 60


def test_measures_of_nothing_are_empty() -> None:
    assert OrbitMeasures().cycles == 0
    assert Outcome.CYCLE.name == "CYCLE"
