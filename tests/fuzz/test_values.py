"""Any value in any place of a spec: drawn by hypothesis, which makes what fails small."""

from copy import deepcopy
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.fuzz.arena import Arena
from tests.fuzz.seeds import seeds
from tests.fuzz.spec_attempt import attempts
from tests.fuzz.spec_case import STAGES, SpecCase
from tests.fuzz.tree import spots
from tests.fuzz.yaml_text import write

SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", STAGES)
@settings(
    max_examples=30,
    derandomize=True,
    database=None,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(data=st.data())
def test_any_value_anywhere(arena: Arena, kind: str, data: st.DataObject) -> None:
    few = [one for one in seeds()[kind] if len(str(one)) < 4000]
    tree: Any = deepcopy(data.draw(st.sampled_from(few)))
    spot = data.draw(st.sampled_from(spots(tree)))
    if isinstance(spot.inside, dict) and data.draw(st.booleans()):
        spot.inside[data.draw(st.text(max_size=8))] = data.draw(VALUES)
    else:
        spot.put(data.draw(VALUES))
    case = SpecCase(kind, write(tree, Random(0)).encode("utf-8", errors="surrogatepass"), ())
    for one in attempts(case, arena):
        assert not one.breaches, (one, case.data)
