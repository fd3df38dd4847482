"""YAML with places: values, positions, duplicate keys, and what is refused."""

from pathlib import Path

import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.spec.source import dotted, parse, parse_value, read


def faults(text: str) -> list[str]:
    with pytest.raises(SpecError) as caught:
        parse(text, "f.yaml")
    return [str(fault) for fault in caught.value.faults]


def test_values_follow_yaml_1_2() -> None:
    source = parse("a: 1e-4\nb: yes\nc: 0o17\nd: ~\ne: [1, 2.5, x]\n", "f.yaml")
    assert source.value == {"a": 1e-4, "b": "yes", "c": 15, "d": None, "e": [1, 2.5, "x"]}


def test_positions_are_of_keys_and_values() -> None:
    source = parse("a:\n  b: 1\n  c: [2, 33]\n", "f.yaml")
    assert source.keys["a", "c"] == (3, 3)
    assert source.values["a", "c", 1] == (3, 10)
    assert str(source.fault(("a", "c", 1), "wrong")) == "f.yaml:3:10: a.c[1]: wrong"


def test_missing_key_is_placed_at_its_parent() -> None:
    source = parse("a:\n  b: 1\n", "f.yaml")
    assert str(source.fault(("a", "z"), "missing")) == "f.yaml:1:1: a.z: missing"


def test_every_duplicate_key_is_a_fault() -> None:
    assert faults("a: 1\nb: {c: 1, c: 2}\na: 2\n") == [
        "f.yaml:2:11: b.c: duplicate key, first given at line 2",
        "f.yaml:3:1: a: duplicate key, first given at line 1",
    ]


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("a: [1, 2\n", "f.yaml:2:1: not YAML"),
        ("a: 1\n b: 2\n", "f.yaml:2:3: not YAML"),
        ("\ta: 1\n", "f.yaml:1:1: not YAML"),
        ("- 1\n", "f.yaml:1:1: a spec is a mapping"),
        ("", "f.yaml:1:1: empty"),
        ("a: !!python/object:os.system x\n", "f.yaml:1:4: a: tag"),
        ("a: *nobody\n", "f.yaml:1:4: not YAML"),
        ("? [1, 2]\n: 3\n", "f.yaml:1:3: a key must be a word"),
        ("a: 1\n---\nb: 2\n", "f.yaml:2:1: not YAML"),
    ],
)
def test_what_is_not_a_spec(text: str, place: str) -> None:
    assert faults(text)[0].startswith(place)


def test_aliases_cannot_explode() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 9)]
    assert "more than" in faults("\n".join(lines))[0]


def test_alias_to_itself_is_refused() -> None:
    assert "levels" in faults("a: &x [*x]\n")[0]


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"none\.yaml: No such file"):
        read(tmp_path / "none.yaml")
    binary = tmp_path / "b.yaml"
    binary.write_bytes(b"a: 1\nb: \xff\n")
    with pytest.raises(SpecError, match=r"b\.yaml:2:1: not UTF-8"):
        read(binary)
    large = tmp_path / "l.yaml"
    large.write_bytes(b"#" * 1_000_001)
    with pytest.raises(UsageError, match="larger than"):
        read(large)


def test_override_values_are_yaml() -> None:
    assert parse_value("[1, 2e3]") == [1, 2000.0]
    assert parse_value("null") is None
    with pytest.raises(ValueError, match="not YAML"):
        parse_value("[1,")


def test_paths_as_the_user_writes_them() -> None:
    assert dotted(("grid", "bias.torque", 2)) == 'grid["bias.torque"][2]'
