"""YAML with places: values, positions, duplicate keys, and what is refused."""

import re
from pathlib import Path

import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.specs.source import dotted, parse, parse_value, read


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
        (":\n%YAML 9.9", "f.yaml:2:1: must be YAML 1.2, not 9.9"),
        ("# 1\n%YAML 1.1\n---\na: yes\n", "f.yaml:2:1: must be YAML 1.2, not 1.1"),
        ("a: !!int\n", "f.yaml:1:4: a: must be a number, got ''"),
        ("a: !!float ''\n", "f.yaml:1:4: a: must be a number, got ''"),
        ("a: !!int '-'\n", "f.yaml:1:4: a: must be a number, got '-'"),
        ("a: !!bool maybe\n", "f.yaml:1:4: a: must be true or false, got 'maybe'"),
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


@pytest.mark.parametrize("deep", ["[" * 60, "{a: " * 60, "- " * 60, "[" * 30 + "{a: " * 30, "? " * 60])
def test_what_is_nested_too_deeply_is_given_up_where_it_is(deep: str) -> None:
    """Read on, brackets would take seconds: for each the parser looks back at all that are open."""
    (found,) = faults(f"a: 1\nb:\n  {deep}{'[' * 100_000}\n")
    assert re.match(r"f.yaml:3:\d+: not YAML: more than 50 levels$", found)


def test_fifty_levels_are_read() -> None:
    assert parse(f"a: {'[' * 48}1{']' * 48}\n", "f.yaml").value


def test_no_mapping_has_a_thousand_keys() -> None:
    (found,) = faults("a:\n" + "".join(f"  k{i}: 1\n" for i in range(1001)))
    assert found.startswith("f.yaml:2:3: a: more than 1000 keys in one mapping; HKNOB_SPEC_LIMIT=10 in the environment")
    assert len(parse("".join(f"k{i}: 1\n" for i in range(1000)), "f.yaml").value) == 1000


@pytest.mark.parametrize("escape", ["\\0", "\\uD800", "\\uDFFF\\uD800"])
def test_text_that_no_file_can_have_is_refused(escape: str) -> None:
    assert faults(f'a: "x{escape}"\n')[0].startswith("f.yaml:1:4: a: must be text that a file can have")
    assert faults(f'"{escape}": 1\n') == ["f.yaml:1:1: a key must be text that a file can have"]
    with pytest.raises(ValueError, match="must be text"):
        parse_value(f'"{escape}"')


def test_yaml_1_2_may_say_so() -> None:
    assert parse("%YAML 1.2\n---\na: yes\n", "f.yaml").value == {"a": "yes"}


def test_an_anchor_may_be_used_again() -> None:
    """YAML 1.2, section 3.2.2.2; no warning, for that would be an error here."""
    assert parse("a: &x 1\nb: &x 2\nc: *x\n", "f.yaml").value == {"a": 1, "b": 2, "c": 2}


def test_what_is_read_once_more_is_its_own() -> None:
    text = "a: {b: [1, 2]}\n"
    first = parse(text, "f.yaml")
    first.value["a"]["b"].append(3)
    assert parse(text, "g.yaml").value == {"a": {"b": [1, 2]}}
    assert str(parse(text, "g.yaml").fault(("a",), "wrong")) == "g.yaml:1:4: a: wrong"


def test_what_cannot_be_read_cannot_be_read_again() -> None:
    text = f"a: {'9' * 5000}\n"
    assert faults(text) == faults(text)


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


def test_levels_that_aliases_add_are_counted() -> None:
    lists = "a: &list {}1{}\nb: {}*list{}\n"
    assert parse(lists.format("[" * 25, "]" * 25, "[" * 24, "]" * 24), "f.yaml").value
    assert faults(lists.format("[" * 25, "]" * 25, "[" * 25, "]" * 25)) == [
        "f.yaml:1:35: more than 50 levels of keys and lists, aliases expanded"
    ]
