"""Rows of trials: what is doubtful about one is said."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from hknob_cli.hardware.tables import trial_row
from tests.hardware.campaigns import Faulty, campaign, planned


def test_a_buzz_below_the_encoder_is_not_passed_off_as_one_of_no_size(tmp_path: Path) -> None:
    one = campaign(tmp_path, Faulty()).run()[0]
    row = trial_row(one, planned().course)
    assert (row["sustained"], row["p2p_rad"] > 0.0, row["fault"]) == (True, True, "")
    place = one.table.column_names.index("angle_rad")
    still = one.table.set_column(place, one.table.schema.field(place), pa.array(np.zeros(one.table.num_rows)))
    row = trial_row(one._replace(table=still), planned().course)
    assert (row["sustained"], row["p2p_rad"]) == (True, 0.0)
    assert row["fault"] == "the buzz is smaller than the device's own encoder can tell"
