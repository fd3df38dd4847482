"""Which tests watch over which proofs: quick ones, that run in the interpreter."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
ENGINE = ROOT / "hknob_cli" / "engine"
PROOF, SETS, GENERAL = "tests/engine/proof/", "tests/engine/sets/", "tests/engine/general/"
CAPTURE = (f"{PROOF}test_capture_margins.py", f"{SETS}test_ball.py")
CUTTING = (f"{PROOF}test_cutting_margins.py",)
ARCS = (f"{PROOF}test_arc_margins.py", f"{PROOF}test_arc_ends.py", f"{SETS}test_arc.py")
STANDSTILL = (f"{PROOF}test_standstill_margins.py", f"{GENERAL}test_inner_region.py")
WATCHED: dict[str, tuple[str, ...]] = {
    "certificate.py": ("tests/engine/test_certificate.py", f"{PROOF}test_certificate_margins.py"),
    "rest.py": ("tests/engine/test_rest.py", f"{PROOF}test_rest_margins.py"),
    "follow.py": ("tests/engine/test_rest.py", f"{SETS}test_ball.py", f"{PROOF}test_follow_margins.py"),
    "sets/ball.py": CAPTURE,
    "sets/known.py": CAPTURE,
    "sets/polygon.py": CUTTING,
    "sets/lattice.py": CUTTING,
    "sets/arc.py": ARCS,
    "sets/arc_cut.py": ARCS,
    "sets/box.py": (f"{PROOF}test_box_margins.py",),
    "general/standstill.py": STANDSTILL,
    "general/inner_region.py": (f"{PROOF}test_region_margins.py", f"{GENERAL}test_inner_region.py"),
    "general/powers.py": (f"{PROOF}test_power_margins.py", f"{GENERAL}test_powers.py"),
    "general/period_map.py": (f"{PROOF}test_period_map_margins.py", f"{PROOF}test_turn_margins.py"),
    "general/follow.py": (f"{PROOF}test_general_follow_margins.py", f"{GENERAL}test_inner_region.py"),
}
# Of these files, what would take longer than all others together.
LEFT_OUT = (f"{GENERAL}test_inner_region.py::test_the_share_at_rest_never_falls_with_the_limit",)


def watchers_of(path: Path) -> list[Path]:
    """Files of tests that watch over an engine file."""
    return [ROOT / name for name in WATCHED[path.relative_to(ENGINE).as_posix()]]
