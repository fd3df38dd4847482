"""The numbers of docs/explanation/dissertation.md about several axes, from experiments/two_axes.yaml."""

from math import hypot

from tests.conftest import EXPERIMENTS, swept

from .page import says

LEVER_MM = 50.0


def test_two_axes_pressed_into_a_corner() -> None:
    found = swept(EXPERIMENTS / "two_axes.yaml").cells.to_pandas().sort_values("knob.inertia")
    inner, outer = (row for _, row in found.iterrows())
    assert inner.complete
    assert outer.complete
    assert outer["knob.inertia"] == 4.0 * inner["knob.inertia"]
    one, other = (LEVER_MM * row.p2p_max_rad for row in (inner, outer))
    says(
        "explanation/dissertation.md",
        f"the inner axis ends in one of {inner.orbit_count} limit cycles, the outer in one of {outer.orbit_count}, and",
        f"So the pair ends in one of {inner.orbit_count * outer.orbit_count} combinations",
        f"The largest cycles are {1e3 * inner.p2p_max_rad:.2f} mrad at {inner.frequency_at_max_hz:.0f} Hz "
        f"and {1e3 * outer.p2p_max_rad:.2f} mrad at {outer.frequency_at_max_hz:.0f} Hz",
        f"no more than {one:.2f} mm one way and {other:.2f} mm the other, {hypot(one, other):.2f} mm across",
    )
