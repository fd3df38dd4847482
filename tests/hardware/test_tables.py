"""Rows of trials: what is doubtful about one is said."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from hknob_cli.hardware.tables import campaign_tables, trial_row
from hknob_cli.report.hw_run import describe_clock, describe_hw_run, hw_run_text
from hknob_cli.results.campaign_files import campaign_cells
from tests.hardware.campaigns import SPEC, Faulty, campaign, planned


def test_a_buzz_below_the_encoder_is_not_passed_off_as_one_of_no_size(tmp_path: Path) -> None:
    one = campaign(tmp_path, Faulty()).run()[0]
    row = trial_row(one, planned().course)
    assert (row["sustained"], row["p2p_rad"] > 0.0, row["fault"]) == (True, True, "")
    place = one.table.column_names.index("angle_rad")
    still = one.table.set_column(place, one.table.schema.field(place), pa.array(np.zeros(one.table.num_rows)))
    row = trial_row(one._replace(table=still), planned().course)
    assert (row["sustained"], row["p2p_rad"]) == (True, 0.0)
    assert row["fault"] == "the buzz is smaller than the device's own encoder can tell"


def test_one_trial_that_cannot_be_measured_takes_no_other_ones_rows_away(tmp_path: Path) -> None:
    """Times that do not rise, as from a clock of 1 ms: refused when they arrive, and no crash where they got in."""
    done = campaign(tmp_path, Faulty()).run()
    table = done[1].table
    place = table.column_names.index("time_s")
    coarse = np.floor(table["time_s"].to_numpy() * 200.0) / 200.0
    done[1] = done[1]._replace(table=table.set_column(place, table.schema.field(place), pa.array(coarse)))
    samples, trials, timing = campaign_tables(done, planned())
    rows = trials.to_pylist()
    assert (samples.num_rows, timing.num_rows) == (sum(one.table.num_rows for one in done), 4)
    assert [row["p2p_rad"] is None for row in rows] == [False, True, False, False]
    assert rows[1]["fault"].startswith("cannot be measured: ")
    assert not rows[1]["sustained"]
    assert [row["fault"] for row in rows if row is not rows[1]] == ["", "", ""]
    assert "cannot be measured" in hw_run_text(
        {**describe_hw_run(trials, target_n=0.71), **describe_clock(timing), "name": "x", "status": "computed"}
    )
    assert campaign_cells(rows).num_rows == 3


def test_a_torque_over_the_angle_has_its_digest_in_every_row(tmp_path: Path) -> None:
    """One for each resolution, whatever the rate; another for another torque; none without."""

    def digests(folder: str, torque: str) -> dict[tuple[int, float], str]:
        plan = planned(SPEC + f"detents: {{per_revolution: 12, torque: {torque}}}\n")
        rows = campaign_tables(campaign(tmp_path / folder, Faulty(), plan).run(), plan)[1].to_pylist()
        return {(row["counts_per_rev"], row["sample_rate_hz"]): row["over_angle_digest"] for row in rows}

    found, other = digests("one", "6 mN*m"), digests("other", "5 mN*m")
    assert found[256, 1000.0] == found[256, 2000.0] != found[512, 1000.0] == found[512, 2000.0]
    assert not set(found.values()) & set(other.values())
    assert all(len(one) == 16 for one in found.values())
    plain = campaign_tables(campaign(tmp_path / "plain", Faulty()).run(), planned())[1]
    assert "over_angle_digest" not in plain.column_names
