"""The numbers of docs/explanation/knobs.md, from the experiments that it names."""

from typing import Any

import pandas as pd
import pytest

from hknob_cli.specs.load import load
from hknob_cli.specs.preset import names
from hknob_cli.stages.remedies.run import RemediesStage
from tests.conftest import EXPERIMENTS, swept

from .page import page, says, table

PAGE = "explanation/knobs.md"
GRIPS = (0.71, 14.2)
SLOW = ("smartknob", "hapkit", "moteus_ht1105", "href", "odrive_v3")  # sets of starts: up to a minute, once compiled


def cells(name: str, *overrides: str) -> pd.DataFrame:
    """Cells of an experiment, every orbit of which is proven."""
    found = swept(EXPERIMENTS / f"knob_{name}.yaml", *overrides).cells.to_pandas()
    assert (found.certified_fraction == 1.0).all()
    return found


def size(found: pd.DataFrame, **at: float) -> tuple[float, float]:
    """Peak to peak of the largest cycle (mrad) and its frequency (Hz), or the mean's, of the cell with these values."""
    for key, value in at.items():
        found = found[abs(found[key] - value) <= 1e-9 * value]
    (row,) = found.to_dict("records")
    return 1e3 * row["p2p_max_rad"], row["frequency_hz"]


def rows() -> dict[str, list[str]]:
    """The table of verdicts by preset."""
    return {row[0]: row for row in table(PAGE, "## The verdicts")}


def test_every_preset_has_a_verdict() -> None:
    assert sorted(rows()) == names()
    assert all(row[1] == f"`knob_{name}`" for name, row in rows().items())


@pytest.mark.drawn(3)
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in SLOW else ()) for name in names()]
)
def test_the_verdicts(name: str) -> None:
    """Rest, or the largest cycle, of each grip; proven, and complete."""
    found = swept(EXPERIMENTS / f"knob_{name}.yaml")
    orbits, every = found.orbits.to_pandas(), found.cells.to_pandas()
    assert every.complete.all()
    assert orbits.certified.all()
    for grip, printed in zip(GRIPS, rows()[name][2:4], strict=True):
        here = orbits[orbits["hand.grip_n"] == grip]
        cycles = here[here.outcome == "cycle"]
        if cycles.empty:
            assert set(here.outcome) == {"rest"}
            assert printed == "rests"
            continue
        assert set(here.outcome) == {"cycle"}
        largest = cycles.loc[cycles.p2p_rad.idxmax()]
        several = "up to " if len(cycles) > 1 else ""
        assert printed == f"buzzes, {several}{1e3 * largest.p2p_rad:.3g} mrad at {largest.frequency_hz:.1f} Hz"


def test_friction_and_inertia() -> None:
    found = cells("hapkit_friction")
    small, less = (size(found, **{"knob.coulomb_torque": one})[0] for one in (0.5e-3, 1e-3))
    quiet = found[found["knob.coulomb_torque"] >= 2e-3]
    assert (quiet.at_rest_fraction == 1.0).all()
    says(PAGE, f"shrinks to {small:.2f} mrad with 0.5 mN·m of friction at its sector, to {less:.2f} mrad with 1 mN·m")
    assert (cells("inertias").at_rest_fraction == 1.0).all()
    other = cells("inertias", "scene.from=hapkit", "grid.knob.inertia=[6.7e-5, 2.0e-4, 6.0e-4]")
    assert (other.at_rest_fraction == 0.0).all()


def test_the_smartknob_reports() -> None:
    detent = cells("smartknob_detent")
    free = detent[detent["knob.coulomb_torque"] == 0.0]
    assert (free.at_rest_fraction == 0.0).all()
    assert (detent[detent["knob.coulomb_torque"] >= 0.02e-3].at_rest_fraction == 1.0).all()
    assert round(free.frequency_hz.min()) == 9
    assert 11.0 < free.frequency_hz.max() < 12.0
    weak, _ = size(free, **{"wall.stiffness": 0.017, "actuator.delay_samples": 2})
    strong, _ = size(free, **{"wall.stiffness": 0.0425, "actuator.delay_samples": 3.5})
    says(PAGE, f"{weak:.2f} mrad at strength 1 and two samples of delay, {strong:.1f} mrad (0.38°) at strength 2.5")
    assert f"{strong * 1e-3 * 57.29578:.2f}" == "0.38"
    found = cells("smartknob_derivative")
    (none, low), (own, pitch), (much, high) = (size(found, **{"wall.damping": one}) for one in (0.0, 1.7e-4, 2.72e-3))
    says(
        PAGE,
        f"buzzes by {none:.3f} mrad at {low:.0f} Hz; with the firmware's by {own:.3f} mrad at {pitch:.0f} Hz; with 16 "
        f"times that by {much:.3f} mrad at {high:.0f} Hz",
    )


def told(cell: dict[str, float]) -> str:
    """What the table of modes says of a cell."""
    if cell["at_rest_fraction"] == 1.0:
        return "rests"
    assert cell["at_rest_fraction"] == 0.0
    return f"{1e3 * cell['p2p_max_rad']:.3g} mrad, {cell['frequency_hz']:.1f} Hz"


HELD = ("scene.hand={table: 1, grip_n: 0.71}", "scene.bias.torque=0.001")


@pytest.mark.long
def test_the_modes_of_a_smartknob() -> None:
    """Untouched, late by 2 and by 3.5 samples, and held lightly; by the detents that the page itself writes."""
    printed = table(PAGE, "## The detents of a SmartKnob")
    assert len(printed) == 5
    for _, detents, *verdicts in printed:
        way = f"scene.detents={detents.strip('`')}"
        free, held = cells("smartknob_modes", way), cells("smartknob_modes", way, *HELD)
        found = [told(cell) for cell in (*free.to_dict("records"), held.to_dict("records")[1])]
        assert verdicts == found, detents
    says(PAGE, *(f"`--set '{HELD[0]}'", f"--set {HELD[1]}`"))


def hums(row: dict[str, Any]) -> str:
    """The largest cycle of a remedy's row, as the page has it: a star where some trials are not proven."""
    if row["p2p_max_rad"] is None:
        return "?"
    text = f"{1e3 * row['p2p_max_rad']:#.3g} mrad, {row['frequency_at_max_hz'] or 0.0:.0f} Hz"
    return ("rests" if row["at_rest_fraction"] == 1.0 else text) + ("*" if row["certified_fraction"] < 1.0 else "")


@pytest.mark.long
@pytest.mark.parametrize("name", ["smartknob", "moteus", "odrive", "idrive"])
def test_the_estimates_of_a_speed(name: str) -> None:
    printed = table(PAGE, "## Which estimate of the speed hums least")
    column = ["smartknob", "moteus", "odrive", "idrive"].index(name)
    with RemediesStage(load(EXPERIMENTS / f"speed_{name}.yaml")) as stage:
        found = {row["remedy"]: row for row in stage.run()[1].to_pylist()}
    assert {row[0]: row[1 + column] for row in printed} == {remedy: hums(row) for remedy, row in found.items()}


def test_the_dead_band() -> None:
    found = cells("dead_band")
    none, half, *more = (size(found, **{"actuator.dead_band": one})[0] for one in (0, 3.2e-4, 9.6e-4, 1.6e-3, 2.24e-3))
    assert none == half
    says(
        PAGE,
        f"changes nothing: {none:.2f} mrad. One of 1.5 steps makes the buzz {more[0]:.2f} mrad, one of 2.5 steps "
        f"{more[1]:.2f} mrad, of 3.5 steps {more[2]:.2f} mrad",
    )


def test_the_hapkit_report() -> None:
    found = cells("hapkit_damping")
    none, quarter, own, eight = (size(found, **{"wall.damping": one})[0] for one in (0.0, 0.011, 0.043, 0.34))
    says(
        PAGE,
        f"{none:.1f} mrad without damping, {quarter:.1f} mrad at a quarter of the firmware's, {own:.1f} mrad at the "
        f"firmware's, {eight:.0f} mrad at eight times that",
    )


def test_the_hapkit_filter() -> None:
    found = cells("hapkit_filtered")

    def at(damping: float, friction: float, low_pass: float = 3.979e-3) -> float:
        return size(
            found,
            **{"controller.damping": damping, "knob.coulomb_torque": friction, "controller.low_pass": low_pass},
        )[0]

    quarter, own = at(0.011, 0.0), at(0.043, 0.0)
    rubbed, unfiltered = at(0.043, 1e-3), at(0.043, 1e-3, 0.0)
    says(
        PAGE,
        f"with that filter {quarter:.1f} mrad at a quarter of the firmware's damping, {own:.1f} mrad at the "
        "firmware's. "
        f"With 1 mN·m of friction at the sector {rubbed:.1f} mrad at the firmware's, {unfiltered:.1f} mrad without the",
    )
    assert quarter > at(0.011, 0.0, 0.0)
    assert own < at(0.043, 0.0, 0.0)
    assert (found[found["knob.coulomb_torque"] == 2e-3].at_rest_fraction == 1.0).all()
    plain = cells("hapkit_damping")  # the same without a filter, by the wall's own damping
    for damping in (0.011, 0.043):
        assert size(plain, **{"wall.damping": damping})[0] == pytest.approx(at(damping, 0.0, 0.0), rel=1e-9)


def test_the_moteus_reports() -> None:
    found = cells("moteus_derivative")
    whole, pitch = size(found, **{"wall.damping": 0.00796})
    half, same = size(found, **{"wall.damping": 0.00398})
    says(PAGE, f"{whole:.4f} mrad at {pitch:.0f} Hz, with half of it {half:.4f} mrad")
    assert same == pytest.approx(pitch, rel=0.01)
    (none,) = found[found["wall.damping"] == 0.0].to_dict("records")
    says(PAGE, f"{1e3 * none['p2p_rad']:.4f} mrad on average at {none['frequency_hz']:.0f} Hz without the derivative")


def test_the_odrive_reports() -> None:
    found = cells("odrive_v3_velocity")

    def at(damping: float, counts: int = 8192, inertia: float = 1e-4) -> tuple[float, float]:
        return size(found, **{"wall.damping": damping, "counts_per_rev": counts, "knob.inertia": inertia})

    assert at(0.00663)[0] == at(0.0133)[0] == 0.0
    own, pitch = at(0.0265)
    says(PAGE, f"buzzes by {own:.3f} mrad at {pitch:.1f} Hz at the default, by {at(0.053)[0]:.2f} mrad at twice that")
    assert all(at(damping, inertia=1e-3)[0] == 0.0 for damping in (0.00663, 0.0133, 0.0265, 0.053))
    coarse, heavy = at(0.0265, counts=2048)[0], at(0.0265, counts=2048, inertia=1e-3)[0]
    says(PAGE, f"at 2048 counts {coarse:.2f} mrad become {heavy:.3f} mrad at the default gain")
    assert at(0.0265, counts=32768)[0] == 0.0
    says(PAGE, f"a quarter as many make it {coarse / own:.0f} times larger")


def test_every_experiment_of_the_page_is_there() -> None:
    for path in EXPERIMENTS.glob("knob_*.yaml"):
        assert f"`{path.stem}`" in page(PAGE), path
