"""Tests of `hknob_cli.hardware.campaign`."""

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.hardware.campaign import check_persons
from tests.hardware.campaigns import SPEC, planned


@pytest.mark.parametrize(("grip", "place"), [("grip: {target: 95}\n", "6:16"), ("grip: {band: 0.1}\nseed: 3\n", None)])
def test_a_grip_beyond_the_table_is_told_where_it_is_written(grip: str, place: str | None) -> None:
    plan = planned(SPEC + grip)
    if place is None:
        check_persons(plan)
        return
    with pytest.raises(SpecError, match=rf"^spec\.yaml:{place}: grip\.target: trial 1 .* up to a grip of 14\.2 N"):
        check_persons(plan)
