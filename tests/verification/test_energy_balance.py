"""Energy audit of every certified cycle: the work of the wall equals the loss in the damping.

Source: the theory, "At a limit cycle the work of the wall torque over a cycle equals the loss in b": over a closed
motion the bias and the hand's spring return what they take. The package computes the two sides independently, the work
from torques and displacements, the loss from the integral of the squared velocity. 1e-10 relative is asked for.

The bound leaves room: the work is a sum of torques times displacements, whose sizes add up to at most 200 times the
loss (10 kHz, 8192 counts, at 60 digits), and a displacement carries the rounding of a position, at most 100 times the
peak-to-peak: 200 * 100 * 2^-53 = 2e-12.
"""

import itertools
from typing import Any

import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.outcome import Outcome

from .scenes import BIASES, COUNTS, RATES_HZ, STIFFNESSES, Settled, hand_on_knob, settle_grid

RELATIVE = 1e-10  # the accuracy promised


def check_balance(rows: list[Settled]) -> int:
    """Check every attractor of a grid; the number of certified cycles."""
    cycles = 0
    for one in rows:
        work, loss = one.measures.wall_work_j, one.measures.damping_loss_j
        if one.attractor.outcome is Outcome.REST:
            assert work == loss == 0.0, one
        if one.attractor.outcome is Outcome.CYCLE and one.attractor.certified:
            assert loss > 0.0, one
            assert abs(work - loss) <= RELATIVE * loss, f"work {work!r} J, loss {loss!r} J: {one}"
            cycles += 1
    return cycles


@pytest.mark.parametrize(("bias", "stiffness"), list(itertools.product(BIASES, STIFFNESSES)))
def test_grid(engine: Engine, bias: str, stiffness: float) -> None:
    """All 49 cells, both readings of the bias, both stiffnesses; no cell is left without a certified attractor."""
    rows = settle_grid(engine, hand_on_knob(bias, stiffness))
    assert all(one.attractor.certified for one in rows)
    assert len({(one.rate_hz, one.counts) for one in rows}) == len(RATES_HZ) * len(COUNTS)
    assert check_balance(rows) >= 42


VARIANTS: dict[str, dict[str, Any]] = {
    "delay 0.3": {"delay": 0.3},
    "delay 1": {"delay": 1.0},
    "delay 1.6": {"delay": 1.6},
    "delay 5.25": {"delay": 5.25},
    "nearest": {"rounding": "nearest"},
    "nearest, offset, delay": {"rounding": "nearest", "offset": 0.3, "delay": 0.45},
    "ceil, offset": {"rounding": "ceil", "offset": 0.6},
    "truncate": {"rounding": "truncate"},
}


@pytest.mark.one_in(5)
@pytest.mark.parametrize("bias", BIASES)
@pytest.mark.parametrize("name", VARIANTS)
def test_delays_and_other_encoders(engine: Engine, bias: str, name: str) -> None:
    """The whole grid again with delays in whole and part samples, and with encoders that round and sit otherwise."""
    rows = settle_grid(engine, hand_on_knob(bias, **VARIANTS[name]))
    assert all(one.attractor.certified for one in rows)
    assert check_balance(rows) >= 10, "too few cycles to mean anything"
