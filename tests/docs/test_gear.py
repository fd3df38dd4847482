"""The numbers of docs/explanation/gear.md, from the experiments that it names."""

from math import log

import pyarrow as pa
import pytest

from tests.conftest import EXPERIMENTS, swept

from .page import agrees, says, table

PAGE = "explanation/gear.md"
Rows = list[dict[str, float]]


def cells(name: str, *overrides: str) -> Rows:
    return _rows(swept(EXPERIMENTS / f"{name}.yaml", *overrides).cells)


def orbits(name: str) -> Rows:
    found = _rows(swept(EXPERIMENTS / f"{name}.yaml").orbits)
    assert all(row["certified"] for row in found)
    return found


def _rows(found: pa.Table) -> Rows:
    rows: Rows = found.to_pylist()
    return rows


def test_a_rigid_gear_and_its_rival() -> None:
    geared, lagging = cells("gear_inertia"), cells("gear_direct")
    plain = cells("gear_direct", "scene.controller=null")
    printed = table(PAGE, "## Rigid")
    assert len(printed) == len(geared) == len(lagging) == len(plain)
    for row, gear, lag, bare in zip(printed, geared, lagging, plain, strict=True):
        added = 7.4**2 * gear["gear.motor_inertia"]
        assert abs(1.9e-6 + added - lag["knob.inertia"]) < 1e-9
        shown = (1e7 * gear["gear.motor_inertia"], 1e7 * added, gear["touch_db"], bare["touch_db"], lag["touch_db"])
        assert all(agrees(text, value) for text, value in zip(row, shown, strict=True)), (row, shown)
    gains = [gear["touch_db"] - lag["touch_db"] for gear, lag in zip(geared, lagging, strict=True)]
    says(PAGE, f"felt less, by {min(gains):.1f} to {max(gains):.1f} dB")
    louder = [
        lag["hearing_relative_db"] - gear["hearing_relative_db"] for gear, lag in zip(geared, lagging, strict=True)
    ]
    assert [one > 0.0 for one in louder] == [False] * 5 + [True, False]
    says(PAGE, "in six of these seven cases", f"it is {louder[5]:.1f} dB louder")
    says(PAGE, f"A motor of {1.9e-6 / 7.4**2 * 1e7:.2f} g·cm² already doubles")


@pytest.mark.long
def test_a_mesh_that_yields() -> None:
    rigid = {row["gear.motor_inertia"]: row for row in cells("gear_inertia")}
    rows = cells("gear_compliance")
    stiff = [row for row in rows if row["gear.stiffness"] > 30.0]
    off = [abs(row["touch_db"] - rigid[row["gear.motor_inertia"]]["touch_db"]) for row in stiff]
    assert len(stiff) == 12
    assert max(off) <= 0.1
    soft = [row for row in rows if row["gear.stiffness"] == 1.0]
    touch = [row["touch_db"] - rigid[row["gear.motor_inertia"]]["touch_db"] for row in soft]
    sound = [row["hearing_relative_db"] - rigid[row["gear.motor_inertia"]]["hearing_relative_db"] for row in soft]
    says(PAGE, f"felt {-touch[0]:.0f} dB less, and sounds {sound[0]:.0f} dB louder")
    says(PAGE, f"With the heaviest it is felt {touch[-1]:.0f} dB more")
    pitches = [row["frequency_hz"] for row in orbits("gear_compliance") if row["gear.stiffness"] == 1.0]
    says(PAGE, f"at {min(pitches):.0f} to {max(pitches):.0f} Hz")


@pytest.mark.long
def test_where_teeth_would_part() -> None:
    found = orbits("gear_compliance")
    says(PAGE, f"in {sum(row['mesh_least_nm'] > 0.0 for row in found)} of the {len(found)} cycles found")
    by_push = orbits("gear_push")
    assert all(row["mesh_least_nm"] < 0.0 for row in by_push if row["bias.torque"] < 3.1e-4)
    assert all(row["mesh_least_nm"] > 0.0 for row in by_push if row["bias.torque"] > 2.9e-3)


@pytest.mark.long
def test_a_backlash() -> None:
    found = swept(EXPERIMENTS / "gear_backlash.yaml")
    rows = _rows(found.orbits)
    printed = table(PAGE, "(`rattle_p2p_rad`)")
    cells = sorted({(row["bias.torque"], row["gear.backlash"]) for row in rows})
    assert len(cells) == 12
    for line, push in zip(printed, sorted({push for push, _ in cells}), strict=True):
        for shown, backlash in zip(line[1:], sorted({play for _, play in cells}), strict=True):
            there = [row for row in rows if (row["bias.torque"], row["gear.backlash"]) == (push, backlash)]
            repeats = backlash == 0.0 or push > 9e-4
            assert all(row["certified"] == repeats for row in there)
            if repeats:
                assert agrees(shown, 1e3 * max(row["knob_p2p_rad"] for row in there)), (push, backlash, there)
            else:
                # The last bit of rounding decides which stretch of a chaotic motion is looked at: twelve starts
                # apart by 1e-12 swing between 17 % less and 11 % more than their median, which is what the page shows.
                swing = 1e3 * max(row["rattle_p2p_rad"] for row in there)
                assert abs(float(shown) - swing) <= 0.2 * float(shown), (push, backlash, there)
    says(PAGE, "differ by up to 17 % from their median")
    rates = [row["parting_per_s"] for row in rows if row["parting_per_s"] is not None]
    assert len(rates) == 6
    # Of the twelve starts: 62 to 115, 86 to 109 and 209 to 233 in the cells of one backlash.
    assert all(50.0 < rate < 250.0 for rate in rates), rates
    says(PAGE, "grows by 60 to 230 per second")
    says(PAGE, f"tenfold within {1e3 * log(10.0) / 230.0:.0f} to {1e3 * log(10.0) / 60.0:.0f} ms")


@pytest.mark.long
def test_cogging_behind_teeth_with_play() -> None:
    found = swept(EXPERIMENTS / "gear_cogging.yaml")
    cells, rows = _rows(found.cells), _rows(found.orbits)
    for line, torque in zip(table(PAGE, "of four places: rest, proven"), (1e-5, 3e-5, 1e-4, 3e-4), strict=True):
        there = [cell for cell in cells if cell["cogging.torque"] == torque]
        assert len(there) == 4
        rests = sum(cell["at_rest_fraction"] == 1.0 and cell["certified_fraction"] == 1.0 for cell in there)
        moves = sum(cell["undecided_fraction"] == 1.0 for cell in there)
        assert [int(number) for number in line[1:]] == [rests, 4 - rests - moves, moves]
    swings = [1e3 * row["rattle_p2p_rad"] for row in rows if row["rattle_p2p_rad"] is not None]
    assert len(swings) == 11
    assert all(3.0 <= swing <= 6.0 for swing in swings), swings
    says(PAGE, "the knob swings by 3 to 6 mrad")
    assert all(1e3 * row["knob_p2p_rad"] < 2.0 for row in rows if row["outcome"] == "cycle")
    says(PAGE, "or buzz by less than 2 mrad")
