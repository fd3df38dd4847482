"""How an arc of phases lies, with a relative error that would be seen: against matrix exponentials of SciPy."""

import numpy as np
import pytest

from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.sets.curve import drift_over, measure_arc, move_centre, place_on, rate_at
from hknob_cli.engine.general.sets.room import make_arc_room
from tests.engine.general.sets.cells import bounds, cell, centre, zeros
from tests.engine.sets.loops import expm

BLUR = 0.25


def flow(a: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
    """exp(A t), and its integral from 0."""
    n = len(a)
    whole = expm(np.block([[a, np.eye(n)], [np.zeros((n, 2 * n))]]) * t)
    return whole[:n, :n], whole[:n, n:]


@pytest.mark.parametrize("kind", ["whole delay", "lag", "stiff finger, late"])
def test_an_arc_is_as_long_as_its_rate_and_as_far_from_its_chord_as_half_its_turn(kind: str) -> None:
    knob = cell(kind)
    body, drift, n = knob.body, bounds(knob)._replace(blur=BLUR), knob.body.order
    room = make_arc_room(zeros, n, knob.delay_line)
    a = np.reshape(body.matrices[: n * n], (n, n))
    start = knob.start(0.02, -1.5)
    rate = np.array(body.vectors[:n]) + a @ start
    for phase in (0.0, 0.3, 1.0):
        place = zeros(n)
        place_on(phase, start, place, room, body)
        np.testing.assert_allclose(place, start + flow(a, phase)[1] @ rate, rtol=1e-9, atol=1e-9)
    for low, high, sample in ((0.0, 1.0, 0), (0.25, 0.375, 0), (0.25, 0.75, 1), (0.6, 0.9, 13)):
        half, moved = 0.5 * (high - low), np.linalg.matrix_power(flow(a, 1.0)[0], sample)
        there, middle = flow(a, low)[0] @ rate, flow(a, low + half)[0] @ rate
        radius, bulge = measure_arc(low, high, sample, room, drift, body)
        assert radius == pytest.approx(half * norm(moved @ there, body) * (1.0 + BLUR), rel=1e-9, abs=0.0)
        assert bulge == pytest.approx(0.5 * half**2 * norm(moved @ a @ there, body) * (1.0 + BLUR), rel=1e-9, abs=0.0)
        np.testing.assert_allclose(room.below[:n], -moved @ flow(a, half)[1] @ there, rtol=1e-8, atol=1e-12)
        np.testing.assert_allclose(room.above[:n], moved @ flow(a, half)[1] @ middle, rtol=1e-8, atol=1e-12)
        out = zeros(n)
        rate_at(low, room, body, out)
        np.testing.assert_allclose(out, there, rtol=1e-9, atol=1e-12)
        for come, to in ((low, high), (high, low), (low, low)):
            move_centre(centre(start, [], sample=float(sample)), come, to, room, drift, body, out)
            way = moved @ flow(a, min(come, to))[0] @ flow(a, abs(to - come))[1] @ rate
            np.testing.assert_allclose(out, start + np.sign(to - come) * way, rtol=1e-8, atol=1e-12)
    for t in (0.0, 0.5, 0.8125, 1.0, 0.1):
        out = zeros(n)
        drift_over(t, there.tolist(), out, body, zeros(2 * n))
        np.testing.assert_allclose(out, flow(a, t)[1] @ there, rtol=1e-9, atol=1e-12)
