"""A sample clock that jitters, in specs: what it goes with, faults with their place, and what a sweep's files have."""

from typing import Any

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.report.scene_words import scene_sentences
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep.run import SweepStage
from tests.specs.small_cells import CHANGES, KINDS, swept

pytestmark = pytest.mark.usefixtures("loop_not_kept")

JITTER = {"scene": {"clock": {"jitter": 0.05}}}


def planned(*changes: dict[str, Any]) -> SweepPlan:
    """The base with jitter and with more; without keys that are None."""
    return swept(JITTER, *changes)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"scene": {"clock": {"jitter": 1.0}}}, "scene.clock.jitter: must be <= 0.9"),
        ({"scene": {"clock": {"jitter": -0.1}}}, "scene.clock.jitter: must be >= 0"),
        ({"scene": {"clock": {"jitter": "5 ms"}}}, "scene.clock.jitter: must be a number"),
        ({"scene": {"clock": {"jiter": 0.1}}}, "scene.clock.jiter: unknown key; did you mean 'jitter'?"),
        ({"scene": {"clock": {"seed": 0.5}}}, "scene.clock.seed: must be a whole number"),
        ({"scene": {"clock": {"seed": -1}}}, "scene.clock.seed: must be >= 0"),
        (CHANGES["delay"], "scene.clock.jitter: must be 0 beside a delay by a part of a sample: intervals are not"),
        (CHANGES["unsampled"], "scene.clock.jitter: must be absent where sampling is continuous: there is no clock"),
        (
            {"perceive": {"knob_radius": 0.0089}},
            "perceive: must be absent where the sample clock jitters: no motion repeats",
        ),
        (
            {"starts": None} | {"starts": "anywhere"},
            "scene.clock.jitter: must be absent where starts are anywhere: the next sample comes at another time",
        ),
    ],
)
def test_faults(change: dict[str, Any], said: str) -> None:
    with pytest.raises(SpecError) as error:
        planned(change)
    (fault,) = error.value.faults
    assert f"{fault.key}: {fault.message}".startswith(said)


def test_a_grid_of_it_has_its_place() -> None:
    axis = {"grid": {"clock.jitter": [0.0, 0.1]}}
    assert planned(axis).axes["clock.jitter"] == [0.0, 0.1]
    with pytest.raises(SpecError) as error:
        planned(axis, {"scene": {"clock": {"jitter": 0.0}}}, CHANGES["delay"])
    (fault,) = error.value.faults
    assert fault.key == 'grid["clock.jitter"]'


@pytest.mark.parametrize("starts", ["phases", "one", "ranges"])
def test_files_have_swing_and_pitch_of_what_does_not_rest(starts: str) -> None:
    plan = planned({"grid": {"clock.jitter": [0.0, 0.2]}, "starts": None}, {"starts": KINDS[starts]})
    plan = plan._replace(starts=plan.starts._replace(phases=2), max_samples=4096)
    tables = SweepStage(plan, jobs=1).run()
    still, moved = tables.cells.to_pylist()
    assert still["certified_fraction"] == 1.0
    assert still["jitter_max_rad"] is None
    assert moved["certified_fraction"] == 0.0
    row = next(row for row in tables.orbits.to_pylist() if row["clock.jitter"] == 0.2)
    assert row["reason"].startswith("no two sample intervals are alike")
    assert moved["jitter_max_rad"] == row["jitter_p2p_rad"] > 1e-4
    assert still["clock_bound_rad"] is None
    assert moved["clock_bound_rad"] >= row["jitter_range_rad"]
    assert row["jitter_range_rad"] >= row["jitter_p2p_rad"]
    assert 20.0 < row["jitter_frequency_hz"] < 400.0


def test_rest_of_every_clock_is_in_the_files() -> None:
    """A hand that rests under all intervals; one with friction rests too, but that is not built for every clock."""
    hand = {"inertia": 3e-7, "damping": 3.45e-3, "stiffness": 0.3}
    for change, bound in (({}, 0.0), ({"knob": {"coulomb_torque": 1e-5}}, None)):
        plan = planned({"scene": {"hand": hand, "bias": {"torque": 7e-3}, **change}})._replace(max_samples=4096)
        tables = SweepStage(plan, jobs=1).run()
        (cell,) = tables.cells.to_pylist()
        assert cell["at_rest_fraction"] == 1.0
        assert cell["clock_bound_rad"] == bound


def test_a_seed_draws_its_intervals() -> None:
    def swing(seed: int) -> float:
        plan = planned({"scene": {"clock": {"seed": seed}}})._replace(max_samples=4096)
        (row,) = SweepStage(plan, jobs=1).run().orbits.to_pylist()
        return float(row["jitter_range_rad"])

    assert swing(1) == swing(1) != swing(2)


def test_words_of_a_scene() -> None:
    plan = planned()
    said = "Clock: 1000 Hz, each interval shorter or longer by up to 0.05 of it; the torque is held"
    assert any(line.startswith(said) for line in scene_sentences(plan.scene, plan.axes))
