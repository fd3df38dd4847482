"""The Nyquist picture is of a relay without memory: with hysteresis, in the scene or the grid, it is refused."""

import pyarrow as pa
import pytest

from hknob_cli.figures import draw
from hknob_cli.results.result_set import Held, MissingError, One
from tests.conftest import SPEC, loaded


@pytest.mark.parametrize("axis", ["encoder.hysteresis_counts", "encoder.backlash", ""])
def test_there_is_no_ray_of_a_relay_with_memory(axis: str) -> None:
    plan = loaded(SPEC)
    table = pa.Table.from_pylist([{"sample_rate_hz": 1000.0, "counts_per_rev": 1024, **({axis: 0.5} if axis else {})}])
    result = Held("one", "dfa", {"dfa": table}, table.column_names)
    encoder = plan.scene.encoder
    assert encoder is not None
    result.scene = plan.scene if axis else plan.scene._replace(encoder=encoder._replace(hysteresis_counts=0.5))
    with pytest.raises(MissingError, match="an encoder with hysteresis, whose inverse is no ray"):
        draw("nyquist", One(result), "one", {})
