"""Which tests watch over which proofs: quick ones, that run in the interpreter."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
ENGINE = ROOT / "hknob_cli" / "engine"
PLAIN = ("tests/engine/test_certificate.py", "tests/engine/test_rest.py", "tests/engine/proof/test_*.py")
SETS = (*PLAIN, "tests/engine/sets/test_*.py", "!tests/engine/sets/test_search.py")
GENERAL = ("tests/engine/general/test_*.py", "tests/engine/proof/test_*.py", "!tests/engine/general/test_proof.py")
WATCHED: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("certificate.py", "rest.py", "follow.py"), SETS),
    **dict.fromkeys((f"sets/{name}.py" for name in ("ball", "known", "arc", "polygon", "lattice", "box")), SETS),
    **dict.fromkeys(
        (f"general/{name}.py" for name in ("period_map", "standstill", "inner_region", "powers", "follow")), GENERAL
    ),
}


def tests_of(path: Path) -> list[Path]:
    """Files of tests for an engine file; a pattern that begins with ! leaves files out."""
    found: dict[Path, None] = {}
    for pattern in WATCHED[path.relative_to(ENGINE).as_posix()]:
        if pattern.startswith("!"):
            for one in ROOT.glob(pattern[1:]):
                found.pop(one, None)
        else:
            found.update(dict.fromkeys(sorted(ROOT.glob(pattern))))
    return list(found)
