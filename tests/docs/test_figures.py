"""The numbers of docs/explanation/figures.md, from the experiments that it names."""

from math import pi

import numpy as np
import pandas as pd
import pytest

from tests.conftest import EXPERIMENTS, swept

from .page import agrees, says, table

PAGE = "explanation/figures.md"
ROUNDING = 1e-12  # of the work of the wall
RATES = [100, 215, 464, 1000, 2154, 4642, 10000]


def orbits(name: str, *overrides: str) -> pd.DataFrame:
    """Orbits of an experiment that cycle, with the shares of the wall's work, %."""
    found = swept(EXPERIMENTS / f"{name}.yaml", *overrides).orbits.to_pandas()
    return shared(found)


def shared(found: pd.DataFrame) -> pd.DataFrame:
    found = found[found.outcome == "cycle"].copy()
    work = found.late_entry_j + found.late_exit_j + found.staircase_j
    for part in ("entry", "exit", "staircase"):
        column = "staircase_j" if part == "staircase" else f"late_{part}_j"
        found[part] = 100.0 * found[column] / work
    return found


def span(values: "pd.Series[float]") -> str:
    return f"{values.min():.0f} to {values.max():.0f} %"


def test_kinds_of_orbits_and_where_their_energy_leaks_in(main_grid) -> None:
    """Three kinds: one step of torque and out of the wall, never out, several counts and out."""
    found = shared(pd.DataFrame(main_grid["printed:orbits"]))
    leaves = found.max_rad > 0.0
    none = found.staircase.abs() < 100.0 * ROUNDING
    one, inside, several = found[leaves & none], found[~leaves], found[leaves & ~none]
    says(
        PAGE,
        f"Of the {len(found)} orbits with bias 0.001 N·m, - {len(one)} feel one step of torque",
        f"leave the wall (up to {one.counts_per_rev.max()} counts): entry {one.entry.mean():.0f} % ({span(one.entry)}) "
        f"and exit {one.exit.mean():.0f} % ({span(one.exit)}) on average.",
        f"Staircase is exactly 0 in {(one.staircase_j == 0.0).sum()} of them and rounding in the others",
        f"- {len(inside)} never leave the wall ({inside.counts_per_rev.min()} counts and more, from "
        f"{inside.sample_rate_hz.min():.0f} Hz up): the bias rests at {1e3 * 0.001 / 0.27:.1f} mrad",
        f"- {len(several)} span several counts and leave the wall, {(several.sample_rate_hz < 300.0).sum()} of them "
        f"at 100 and 215 Hz: entry {span(several.entry)}, exit {span(several.exit)}, "
        f"staircase {span(several.staircase)}",
    )
    assert one.staircase.abs().max() < 1e-13  # %: at most 1e-15 of the work
    assert inside.staircase.to_numpy() == pytest.approx(100.0)
    deep = -one.min_rad * one.counts_per_rev / (2.0 * pi)
    assert (deep > 1.0).sum() == 1
    assert one.sample_rate_hz[deep.idxmax()] == 100.0
    says(PAGE, f"dips {deep.max():.1f} counts deep between two samples")


def test_half_a_count_s_bias_shares_the_leak_evenly(main_grid) -> None:
    found = shared(pd.DataFrame(main_grid["half_quantum:orbits"]))
    one = found[(found.max_rad > 0.0) & (found.staircase.abs() < 100.0 * ROUNDING)]
    worst = (one.entry - 50.0).abs().max()
    assert 0.13 < worst < 0.14
    says(PAGE, f"50:50 within 0.14 % in the symmetric relay of half a count's bias ({len(one)} orbits)")


def test_the_table_of_the_leak(main_grid) -> None:
    """Means over the cells of a row, each of its orbits weighted by their shares of the starts."""
    printed = table(PAGE, "## Where the energy leaks in")
    assert [int(row[0]) for row in printed] == RATES
    for name, columns in (("printed", (1, 2, 3)), ("half_quantum", (4, 5, 6))):
        found = shared(pd.DataFrame(main_grid[f"{name}:orbits"]))
        for part, column in zip(("entry", "exit", "staircase"), columns, strict=True):
            weighted = (found[part] * found.basin_fraction).groupby([found.sample_rate_hz, found.counts_per_rev]).sum()
            for row, mean in zip(printed, weighted.groupby(level=0).mean(), strict=True):
                assert agrees(row[column], mean), (name, part, row[0], mean)


def test_a_delay_makes_some_staircases_negative() -> None:
    said = {}
    for late in (1, 5):
        found = orbits("hand_on_knob", f"scene.actuator={{delay_samples: {late}}}")
        below = found.staircase[found.staircase < -100.0 * ROUNDING]
        said[late] = f"{len(below)} of {len(found)}"
        if late == 1:
            assert agrees("0.5", -below.min())
        assert found.entry.min() > -100.0 * ROUNDING
        assert found.exit.min() > -100.0 * ROUNDING
    says(PAGE, f"staircase is in {said[1]} orbits, by 0.5 % of the work, with five in {said[5]}.")


def test_the_whine() -> None:
    printed = table(PAGE, "## Figure 69")
    for row, name in zip(printed[1:], ("whine", "whine_friction"), strict=True):
        (cell,) = swept(EXPERIMENTS / f"{name}.yaml").cells.to_pylist()
        assert agrees(row[1], 1e3 * cell["p2p_rad"])
        assert agrees(row[2], cell["frequency_hz"])
        assert cell["certified_fraction"] == 1.0
    assert agrees("28", 100.0 * (1.0 - cell["frequency_hz"] / 2200.0))
    assert agrees("0.01", 1e3 * cell["p2p_rad"] / 1.4)


def test_light_contacts() -> None:
    """Figs. 31, 32, 71, 72."""
    coarse, fine = (orbits(name).sort_values("basin_fraction") for name in ("light_contact", "light_contact_fine"))
    often, rare = fine.iloc[-1], coarse.iloc[-1]
    says(
        PAGE,
        f"{1e3 * often.p2p_rad:.3f} mrad at {often.frequency_hz:.0f} Hz, against {1e3 * rare.p2p_rad:.2f} mrad at "
        f"{rare.frequency_hz:.0f} Hz",
        f"cycles between \u2212{-1e3 * rare.min_rad:.2f} and \u2212{-1e3 * rare.max_rad:.2f} mrad",
        f"the torque of one count is {1e3 * 0.27 * 2.0 * pi / 2650:.2f} mN·m at 2650 counts",
        f"half a count's bias, {1e3 * 0.135 * 2.0 * pi / 2650:.2f} mN·m",
    )
    both = orbits("light_contact_half_quantum").sort_values("frequency_hz")
    (slow, fast) = (both.iloc[i] for i in range(2))
    says(
        PAGE,
        f"cycles of {1e3 * slow.p2p_rad:.2f} mrad at {slow.frequency_hz:.0f} Hz and of {1e3 * fast.p2p_rad:.2f} mrad "
        f"at {fast.frequency_hz:.0f} Hz coexist",
    )


def test_the_grid_of_the_hardware_test() -> None:
    """Table and comparison of chapter 8: means of a cell over the trials that cycle."""
    printed = table(PAGE, "## Chapter 8")
    cells = {}
    for name in ("chapter8", "chapter8_friction"):
        for push in ((), ("scene.bias={torque: 0.001}",)):
            cells[name, bool(push)] = swept(EXPERIMENTS / f"{name}.yaml", *push).cells.to_pandas()
    order = [("chapter8", False), ("chapter8_friction", False), ("chapter8", True), ("chapter8_friction", True)]
    wrong = []
    for i, row in enumerate(printed):
        for text, key in zip(row[2:], order, strict=True):
            cell = cells[key].iloc[i]
            assert (int(row[0]), int(row[1])) == (cell.sample_rate_hz, cell.counts_per_rev)
            assert (text == "rest") == (cell.at_rest_fraction == 1.0)
            if text != "rest":
                size, pitch = text.split(", ")
                if not agrees(size, 1e3 * cell.p2p_rad) or not agrees(pitch, cell.frequency_hz):
                    wrong.append((row, key, 1e3 * cell.p2p_rad, cell.frequency_hz))
    assert not wrong
    ratios, smaller = {}, {}
    for push in (False, True):
        plain, rubbed = cells["chapter8", push], cells["chapter8_friction", push]
        cycles = rubbed.at_rest_fraction < 1.0
        ratios[push] = (rubbed.frequency_hz / plain.frequency_hz)[cycles]
        smaller[push] = 100.0 * (rubbed.p2p_rad / plain.p2p_rad - 1.0)[cycles]
    half, printed_push = (f"{r.mean():.1f}" for r in ratios.values())
    says(
        PAGE,
        f"\u00d7 {half} on average ({ratios[False].min():.1f} to {ratios[False].max():.1f}) at half a count's bias; "
        f"\u00d7 {printed_push} ({ratios[True].min():.1f} to {ratios[True].max():.1f}) at 0.001 N·m",
        f"{-smaller[False].mean():.0f} % smaller on average (\u2212{-smaller[False].min():.0f} to "
        f"\u2212{-smaller[False].max():.0f} %) at half a count's bias, {-smaller[True].mean():.0f} % at 0.001 N·m",
        f"half the torque of a count, {1e3 * 0.135 * 2.0 * pi / 2048:.2f} mN·m",
    )
    pitch = {name: cells[name, False].set_index(["sample_rate_hz", "counts_per_rev"]).frequency_hz for name, _ in order}
    slow, fast = (pitch["chapter8_friction"][rate].loc[:1024] for rate in (455.0, 4000.0))
    plain = pitch["chapter8"][455.0]
    says(
        PAGE,
        f"{plain.min():.0f} to {plain.max():.0f} Hz at 455 Hz",
        f"{slow.min():.0f} to {slow.max():.0f} Hz at 455 Hz, {fast.min():.0f} to {fast.max():.0f} Hz at 4 kHz",
    )


def _growth(*overrides: str) -> pd.DataFrame:
    return swept(EXPERIMENTS / "bouncing_ball_growth.yaml", *overrides).cells.to_pandas()


def test_growth_of_energy() -> None:
    """Figs. 29 and 30: table, slopes, scatter."""
    cells = _growth()
    grown = 1e3 * cells.growth_j_per_s2
    for row in table(PAGE, "## Figures 29 and 30"):
        rate = int(row[0])
        here = cells[(cells.sample_rate_hz - rate).abs() < 1.0]
        for text, (index, cell) in zip(row[1:], here.iterrows(), strict=True):
            mean, _, error = text.partition(" ± ")
            assert agrees(mean, grown[index]), (rate, cell.counts_per_rev, grown[index])
            if error:
                assert agrees(error, 1e3 * cell.growth_std_j_per_s2 / np.sqrt(cell.growth_fits)), (rate, error)
    at = {rate: cells[(cells.sample_rate_hz - rate).abs() < 1.0] for rate in (100, 215)}
    assert at[100].growth_fits.max() == 9
    assert at[100].growth_fits.iloc[0] == 0
    says(PAGE, f"growth is {at[215].growth_j_per_s2.min():.3f} to {at[215].growth_j_per_s2.max():.3f} J/s²")
    coarse = cells[cells.sample_rate_hz > 9e3].iloc[:2]
    says(PAGE, "({:.3f} and {:.3f})".format(*1e3 * coarse.growth_std_j_per_s2))
    (ball,) = (scene_of(),)
    for counts, text in ((128, "0.28"), (256, "0.13")):
        step = ball["K"] * 2.0 * pi / counts
        assert agrees(text, 1e3 * ball["g"] * (step - ball["g"]) * 1e-4 / (2.0 * ball["J"])), text


def scene_of() -> dict[str, float]:
    from hknob_cli.specs.source import read

    scene = read(EXPERIMENTS / "bouncing_ball_growth.yaml").value["scene"]
    hand = scene.get("hand", {}).get("inertia", 0.0)
    return {"K": scene["wall"]["stiffness"], "g": scene["bias"]["torque"], "J": scene["knob"]["inertia"] + hand}


@pytest.mark.long
def test_growth_of_energy_over_ten_seconds() -> None:
    cells = _growth("growth.duration=10")
    for rate, here in cells[cells.sample_rate_hz > 300].groupby("sample_rate_hz"):
        spread = here.growth_j_per_s2.max() / here.growth_j_per_s2.min()
        assert spread < (1.04 if rate < 9e3 else 1.06), rate
    fast = 1e3 * cells[cells.sample_rate_hz > 9e3].growth_j_per_s2
    assert agrees("0.044", fast.iloc[0])
    assert all(agrees("0.042", value) for value in fast.iloc[1:])


IMPULSE = {
    "nominal": None,
    "impulse, 1/40 of a sample": "{kind: impulse_damping}",
    "impulse, whole sample": "{kind: impulse_damping, pulse: 1.0}",
    "impulse, crossings timed 20 times a sample": "{kind: impulse_damping, detections: 20}",
    "phase estimation, 360° from the way in": "{kind: phase_damping}",
}


def test_impulse_and_phase_damping() -> None:
    """Figs. 73 to 76: means of 16 starts."""
    rows = table(PAGE, "## Figures 73 to 76")
    assert [row[0] for row in rows] == list(IMPULSE)
    for row, controller in zip(rows, IMPULSE.values(), strict=True):
        sizes, pitches = ([text.strip("()") for text in cell.split()] for cell in row[1:3])
        added = [f"scene.controller={controller}"] if controller else []
        for name, size, pitch in zip(("light_contact", "light_contact_half_quantum"), sizes, pitches, strict=True):
            found = swept(EXPERIMENTS / f"{name}.yaml", "starts.phases=16", "record=null", *added)
            (cell,) = found.cells.to_pylist()
            assert agrees(size, 1e3 * cell["p2p_rad"]), (row[0], name, cell["p2p_rad"])
            assert agrees(pitch, cell["frequency_hz"]), (row[0], name, cell["frequency_hz"])
            if (row[0], name) == ("impulse, 1/40 of a sample", "light_contact"):
                most = max(found.orbits.to_pylist(), key=lambda orbit: orbit["basin_fraction"])
                says(
                    PAGE,
                    f"a cycle of {most['period_samples']} samples has {most['cycles_per_period']} bounces and takes "
                    f"{16 * most['basin_fraction']:.0f} of 16 starts",
                )
