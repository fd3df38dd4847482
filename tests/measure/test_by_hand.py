"""Parts of the measures by hand: sizes evened out, what teeth lose, too many harmonics, swings behind a gear."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.measure import general_orbit
from hknob_cli.measure.forms import loss_form, relaxed
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.measure.growth import bounce_peaks
from hknob_cli.measure.pieces import _balanced
from tests.engine.general.bodies import knob
from tests.engine.test_turning import sampled


def test_a_generators_sizes_are_evened_out_by_powers_of_two() -> None:
    """Rows and columns then have sums within a factor of 2; what they say of the motion, its eigenvalues, stays."""
    rng = np.random.default_rng(3)
    plain = rng.standard_normal((4, 4))
    units = np.array([1.0, 1e6, 1e-3, 1e2])
    scaled = plain * units[None, :] / units[:, None]
    found = _balanced(scaled)
    sizes = np.abs(found)
    ratio = sizes.sum(axis=1) / sizes.sum(axis=0)
    assert (np.abs(np.log2(ratio)) <= 1.0).all()
    assert np.sort_complex(np.linalg.eigvals(found)) == pytest.approx(np.sort_complex(np.linalg.eigvals(plain)))
    power = np.log2(found / scaled)
    assert power == pytest.approx(np.rint(power), abs=1e-9)


@pytest.mark.parametrize(
    ("start", "end", "lost"),
    [(0.25, 0.0, 0.0625), (0.25, -0.25, 0.0625), (-0.75, 0.0, 0.0625), (2.0, 1.0, 3.0), (-0.25, -0.125, 0.0)],
)
def test_teeth_apart_lose_what_their_springs_had_stored(start: float, end: float, lost: float) -> None:
    """Of a stiffness of 2, one way where they overlap above 0, the other below -0.5."""
    body = knob().body._replace(pad_stiffness=2.0, play=0.5)
    assert relaxed(body, start, end) == pytest.approx(lost)


def test_only_a_winding_that_is_there_takes_power() -> None:
    body = knob(hand={}).body
    form = loss_form(body._replace(alpha=0.5))
    assert form.sum() == form[1, 1] == 0.5
    form = loss_form(body._replace(alpha=0.5, coil=3.0, coil_rate=0.25))
    assert (form.sum(), form[2, 2]) == (1.25, 0.75)


class Charting(NamedTuple):
    """An engine that has one chart."""

    one: PeriodSegments

    def chart(self, *_: Any) -> PeriodSegments:
        return self.one


def test_harmonics_are_as_many_as_there_is_time_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of an orbit of three pieces 33 where there is time for a hundred of one."""
    from hknob_cli.engine.attractors import Attractor
    from hknob_cli.engine.outcome import Outcome, Reason

    chart = PeriodSegments(np.ones(3), np.ones(3), np.zeros(3), np.zeros((4, 2)))
    monkeypatch.setattr(general_orbit, "MOST_WORK", 100)
    asked: list[int] = []

    def of_chart(body: Any, chart: Any, period: int, count: int, *, behind: bool) -> Any:
        asked.append(count)
        return np.zeros(count, complex)

    monkeypatch.setattr(general_orbit, "of_chart", of_chart)
    engine: Any = Charting(chart)
    measurer = GeneralMeasurer(knob(), engine)
    measurer.harmonics(Attractor(Outcome.CYCLE, Reason.NONE, 1.0, period=100), 450.0)
    measurer.harmonics(Attractor(Outcome.CYCLE, Reason.NONE, 1.0, period=10), 450.0)
    assert asked == [33, 4]


def test_the_swing_behind_a_gear_is_from_the_least_to_the_most(monkeypatch: pytest.MonkeyPatch) -> None:
    found = iter([(1.0, 3.0), (-0.5, 0.25)])
    monkeypatch.setattr(general_orbit, "extremes", lambda *_: next(found))
    one = knob()._replace(behind=True)
    engine: Any = Charting(PeriodSegments(np.ones(3), np.ones(3), np.zeros(3), np.zeros((4, 2))))
    said = GeneralMeasurer(one, engine)._behind(engine.one)
    assert said == {
        "knob_p2p_rad": pytest.approx(2.0 * one.quantum_rad),
        "mesh_least_nm": pytest.approx(-0.5 * one.torque_nm),
        "mesh_most_nm": pytest.approx(0.25 * one.torque_nm),
    }


def test_compiled_peaks_are_those_that_it_finds() -> None:
    """One at 1.25 periods after the first sample, at 4 counts."""

    def compiled(x: float, v: float, ring: Any, samples: int, loop: Any, times: Any, tops: Any) -> int:
        times[0], tops[0] = 1.25, 4.0
        return 1

    one = sampled(1000.0, 1024)
    found = bounce_peaks(
        one, angle_rad=0.02, velocity_rad_s=0.0, phases=2, duration_s=0.1, functions={"bounce_peaks": compiled}
    )
    assert [peaks.time_s.tolist() for peaks in found] == [pytest.approx([1.5e-3]), pytest.approx([2.0e-3])]
    assert found[0].angle_rad.tolist() == pytest.approx([(4.0 + one.shift) * one.quantum_rad])
