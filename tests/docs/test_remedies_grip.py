"""The numbers of docs/explanation/remedies.md about a grip that follows the push, from the experiment that it names."""

from tests.conftest import EXPERIMENTS, swept

from .page import agrees, says, table

PAGE = "explanation/remedies.md"
STIFFENING = "scene.controller={kind: stiffening, surface: 0.3, depth: 0.35}"
HELD = "scene.squeeze=null"


def mean_size(*overrides: str) -> float:
    """Mean over the deep pushes of the largest cycle; a cell at rest counts as 0."""
    cells = swept(EXPERIMENTS / "grip_follows.yaml", *overrides).cells.to_pandas()
    return float(cells[cells["bias.torque"] > 0.0199].p2p_max_rad.mean())


def test_a_firmer_grip() -> None:
    printed = table(PAGE, "## A firmer grip")
    reference = mean_size(HELD)
    for row, wall in zip(printed, ((), (STIFFENING,)), strict=True):
        assert agrees(row[1], mean_size(HELD, *wall) / reference)
        assert agrees(row[2], mean_size(*wall) / reference)
    says(PAGE, f"begins to grow at {1e3 * 2.0 * 0.7 * 8.9e-3 * 0.71:.1f} mN·m")
