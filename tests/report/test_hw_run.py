"""The summary of a campaign: Table 8's means and deviations from its sixteen numbers; cells over repeats."""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from hknob_cli.figures.hw_run_picture import draw_hw_run
from hknob_cli.printed import table
from hknob_cli.report.hw_run import cells_of, describe_hw_run, grip_table, hw_run_text, quiet_text
from hknob_cli.results.campaign_files import campaign_cells

RATES = (455, 1000, 2000, 4000)


def trial(counts: int, rate: float, **values: Any) -> dict[str, Any]:
    plain = {
        "ended": "buzz",
        "sustained": True,
        "p2p_rad": 1e-3,
        "rms_rad": 4e-4,
        "frequency_hz": 80.0,
        "spectral_hz": 79.0,
        "grip_mean_n": 0.7,
        "wall_torque_nm": 1e-3,
    }
    return {"counts_per_rev": counts, "sample_rate_hz": float(rate), **plain, **values}


def test_the_grip_table_has_the_margins_that_table_8_prints() -> None:
    """Of the printed numbers, which are rounded: so is the margin that is printed, and the one that is shown.

    Numbers that are off by at most 0.005 N put a mean off by as much, and a sample deviation of four by at most
    0.005 sqrt(4 / 3); with two roundings of 0.005 N more neither can be further than 0.0158 N from the print.
    """
    printed = table(8)
    rows = [row for row in printed if isinstance(row["encoder_bits"], float)]
    force = {
        (2 ** int(row["encoder_bits"]), rate): row[name]
        for row in rows
        for rate, name in zip(RATES, [key for key in row if key.startswith("grip_")], strict=True)
    }
    assert len(force) == 16
    cells = cells_of([trial(counts, rate, grip_mean_n=value) for (counts, rate), value in force.items()])
    lines = [line.split() for line in grip_table(cells)[3:]]
    assert [line[0] for line in lines] == ["256", "512", "1024", "2048", "mean", "std"]
    for line, row in zip(lines[:4], rows, strict=True):
        margins = [value for key, value in row.items() if "mean" in key or "std" in key]
        assert len(margins) == 2
        for found, expected in zip(line[5:], margins, strict=True):
            assert abs(float(found) - expected) <= 0.0158
    assert [float(text) for text in lines[4][1:]] == [0.70, 0.70, 0.72, 0.75, 0.72]
    assert lines[5][-1] == "0.05"


def test_cells_are_means_over_the_repeats_that_buzzed() -> None:
    rows = [
        trial(256, 1000, p2p_rad=1e-3, grip_mean_n=0.6),
        trial(512, 1000, sustained=False, p2p_rad=0.0, frequency_hz=0.0),
        trial(256, 1000, p2p_rad=3e-3, grip_mean_n=0.8, frequency_hz=100.0),
        trial(256, 1000, sustained=False, p2p_rad=0.0, grip_mean_n=0.7, frequency_hz=0.0),
    ]
    one, other = cells_of(rows)
    assert (one["trials"], one["sustained"], one["p2p_rad"], one["frequency_hz"]) == (3, 2, 2e-3, 90.0)
    assert round(one["grip_mean_n"], 12) == 0.7
    assert (one["p2p_max_rad"], one["frequency_at_max_hz"]) == (3e-3, 100.0)
    assert (other["trials"], other["sustained"], other["p2p_rad"], other["frequency_hz"]) == (1, 0, None, None)
    assert (other["p2p_max_rad"], other["frequency_at_max_hz"]) == (0.0, None)


def test_the_terminal_has_the_numbers_of_the_page() -> None:
    """Of trials of which some are not sustained, and whose spectrum peaks elsewhere than at their cycles."""
    rows = [
        trial(256, 1000, p2p_rad=0.2e-3, frequency_hz=110.0, spectral_hz=90.0),
        trial(256, 1000, p2p_rad=0.3e-3, frequency_hz=120.0, spectral_hz=95.0),
        trial(256, 1000, sustained=False, ended="rest", p2p_rad=0.0, rms_rad=0.0, frequency_hz=0.0, spectral_hz=0.0),
    ]
    (cell,) = cells_of(rows)
    (page,) = campaign_cells(rows).to_pylist()
    assert page == pytest.approx(cell)
    assert (cell["p2p_rad"], cell["frequency_hz"]) == (pytest.approx(0.25e-3), 115.0)
    assert (cell["p2p_max_rad"], cell["frequency_at_max_hz"]) == (0.3e-3, 120.0)
    more = {"overruns": 0, "gaps": 0, "samples": 10, "fault": "", "grip_std_n": 0.0, "order": 1}
    summary = describe_hw_run(pa.Table.from_pylist([{**row, **more} for row in rows]), target_n=0.7)
    text = hw_run_text({**summary, "name": "knob", "status": "done", "missed_ticks": 0})
    values = [line.split()[-1] for line in text.splitlines() if line.split()[:1] == ["256"]]
    assert values[:4] == ["0.3r", "0.25r", "0.4r", "115r"]
    assert "cycles per second, as a sweep counts them" in text


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ("buzz buzz", ""),
        ("rest rest", "rest"),
        ("buzz rest", "some rest"),
        ("longest rest", "not sustained"),
        ("longest longest", "not sustained"),
        ("buzz operator", "some not sustained"),
    ],
)
def test_a_cell_that_did_not_buzz_says_what_it_was(ends: str, said: str) -> None:
    rows = [trial(256, 1000, ended=end, sustained=end == "buzz") for end in ends.split()]
    assert quiet_text(cells_of(rows)[0]) == said


def test_a_trial_in_which_the_wall_was_never_on_is_drawn(tmp_path: Path) -> None:
    """Without a motion to show, and without a complaint of Matplotlib's, which would be an error here."""
    more = {
        "order": 1,
        "native_counts": 512,
        "grip_std_n": 0.1,
        "steady_first": 0,
        "steady_last": 1,
        "ended": "rest",
        "block": 1,
    }
    row = trial(256, 1000, sustained=False, **{"p2p_rad": 0.0, "frequency_hz": 0.0, **more})
    numbers = {key: [0.0, 0.0] for key in ("angle_rad", "torque_nm", "grip_n")}
    samples = pa.table({"trial": [1, 1], "time_s": [0.0, 1e-3], **numbers, "running": [False, False]})
    draw_hw_run(samples, [row], target_n=0.72, name="still", path=tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 1000
