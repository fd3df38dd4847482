"""Results that someone hostile made: what they say of themselves is text on a page and a terminal, or a fault."""

import copy
import json
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.results.parted import sealed_file
from hknob_cli.results.provenance import KEY, axes_of, describe, origin, record_of, scene_of
from hknob_cli.specs.seal import KEY as SEAL
from tests.conftest import SPEC, loaded
from tests.identified import PEOPLE, conditions, write_conditions
from tests.page.test_layout import Tree
from tests.spoilt_parquet import odd_text, write_odd_names

HOSTILE = "</code></pre><script>alert(1)</script>\x1b[31m\"' onload='$\\frac{$"
RECORD: dict[str, Any] = json.loads(describe(stage="sweep", values=loaded(SPEC).values, overrides=("a=1",)))


def changed(**others: Any) -> bytes:
    return json.dumps({**copy.deepcopy(RECORD), **others}).encode()


# What a file may say of where it comes from, instead of that.
WRONG = {
    "nothing": b"",
    "a list": b"[1]",
    "a number": b"3",
    "not JSON": b"{",
    "nested without end": b"[" * 100_000 + b"]" * 100_000,
    "no spec": changed(spec=None),
    "a list of axes": changed(spec={**RECORD["spec"], "grid": [1]}),
    "no inputs": changed(inputs=[]),
    "inputs without the digest": changed(inputs={}),
    "a number for overrides": changed(overrides=3),
    "a list for the stage": changed(stage=[HOSTILE]),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_provenance_is_none(name: str) -> None:
    metadata = {KEY: WRONG[name]}
    assert record_of(metadata) is None
    assert scene_of(metadata) is None
    assert axes_of(metadata) == []
    origin(metadata)
    assert record_of({KEY: changed()}) == RECORD


def result(folder: Path, stamp: bytes) -> Path:
    folder.mkdir()
    columns = {"sample_rate_hz": [1000.0], "counts_per_rev": [1024], "p2p_rad": [1e-3], "frequency_hz": [80.0]}
    fractions = {f"{name}_fraction": [0.0] for name in ("certified", "at_rest", "diverged", "undecided")}
    table = pa.table({**columns, **fractions, "orbit_count": [1], "note": [HOSTILE]})
    pq.write_table(table.replace_schema_metadata({KEY: stamp}), folder / "cells.parquet")
    return folder


@pytest.mark.parametrize("name", ["nested without end", "no inputs", "a number for overrides"])
def test_results_of_no_origin_are_a_fault(name: str, hknob, spec_file, tmp_path: Path) -> None:
    result(tmp_path / "odd", WRONG[name])
    done = hknob("report", spec_file("kind: report\nname: page\nresults: {odd: odd}\n"))
    assert done.returncode == 2
    assert done.stderr.splitlines() == ["no result 'odd' in odd"]


def test_hostile_provenance_is_text_on_the_page(hknob, spec_file, tmp_path: Path) -> None:
    spec = {**RECORD["spec"], HOSTILE: HOSTILE, "name": HOSTILE}
    stamp = changed(spec=spec, overrides=[HOSTILE], inputs={"spec_sha256": HOSTILE}, stage=HOSTILE)
    result(tmp_path / "odd", stamp)
    done = hknob("report", spec_file("kind: report\nname: page\nresults: {odd: odd}\n"), "-o", "page")
    assert done.returncode == 0, done.stderr
    tree = Tree((tmp_path / "page" / "report.html").read_text())
    assert tree.open == []
    assert tree.count("script") == 1
    assert "".join(tree.text).count("alert(1)") >= 4
    done = hknob(
        "report", spec_file(f"kind: report\nname: page\ntitle: {json.dumps(HOSTILE)}\nresults: {{odd: odd}}\n")
    )
    assert Tree((tmp_path / "results" / "page" / "report.html").read_text()).count("script") == 1


def test_an_axis_that_is_no_column_is_a_fault(hknob, spec_file, tmp_path: Path) -> None:
    result(tmp_path / "odd", changed(spec={**RECORD["spec"], "grid": {HOSTILE: [1]}}))
    done = hknob("report", spec_file("kind: report\nname: page\nresults: {odd: odd}\n"))
    assert done.returncode == 2
    assert done.stderr.startswith("'odd' has no column </code>")
    assert "\x1b" not in done.stderr


def test_hostile_names_of_persons(hknob, spec_file, tmp_path: Path) -> None:
    people = {f"{name}{HOSTILE}": numbers for name, numbers in PEOPLE.items()}
    rows = conditions(people, experiment=HOSTILE)
    write_conditions(tmp_path / "hands" / "conditions.parquet", rows)
    done = hknob("report", spec_file("kind: report\nname: page\nresults: {hands: hands}\n"), "-o", "page")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "page" / "report.html").read_text()
    tree = Tree(page)
    assert tree.open == []
    assert tree.count("script") == 1
    assert "alert(1)" in "".join(tree.text)
    text = SPEC.replace(
        "{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}", "{from: hands, grip_n: 0.71, subject: s}"
    )
    done = hknob("sweep", spec_file(text))
    assert done.returncode == 2
    assert "scene.hand.subject: must be one of" in done.stderr
    assert "\x1b" not in done.stderr


def test_tables_whose_text_is_none_are_a_fault(hknob, spec_file, tmp_path: Path) -> None:
    """Names of columns, or cells, that are not UTF-8: wherever a table is read, and wherever one would be written."""
    hands = tmp_path / "hands.parquet"
    folder = tmp_path / "odd"
    folder.mkdir()
    for spoil in ("names", "cells"):
        if spoil == "names":
            write_odd_names(pa.table({"name": [1.0]}), hands, "name")
        else:
            pq.write_table(pa.table({"level": odd_text()}), hands)
        (folder / "cells.parquet").write_bytes(hands.read_bytes())
        hand = "{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}"
        done = hknob("check", spec_file(SPEC.replace(hand, "{from: hands.parquet, grip_n: 0.71}")))
        assert done.returncode == 2
        assert "spec.yaml:5:16: scene.hand.from: " in done.stderr
        assert "not UTF-8" in done.stderr
        done = hknob("report", spec_file("kind: report\nname: page\nresults: {odd: odd}\n"))
        said = "cells.parquet of 'odd' in odd cannot be read" if spoil == "names" else "no result 'odd' in odd"
        assert (done.returncode, done.stderr) == (2, f"{said}\n")
        predict = SPEC.replace("kind: sweep", "kind: predict").replace("starts: {angle: 0.02, phases: 8}\n", "")
        done = hknob("predict", spec_file(f"{predict}against: odd\n"))
        assert done.returncode == 2
        why = "cannot be read; run the sweep first" if spoil == "names" else "is not the result of a sweep"
        assert done.stderr == f"against: odd/cells.parquet {why}\n"
        done = hknob("sweep", spec_file(), "-o", "odd")
        assert (done.returncode, "not written by hknob" in done.stderr) == (3, True)


def test_a_table_that_cannot_be_read_beside_good_ones(hknob, spec_file, tmp_path: Path) -> None:
    result(tmp_path / "odd", changed())
    (tmp_path / "odd" / "more.parquet").write_bytes(b"PAR1" * 9)
    done = hknob("report", spec_file("kind: report\nname: page\nresults: {odd: odd}\n"))
    assert (done.returncode, done.stderr) == (2, "more.parquet of 'odd' in odd cannot be read\n")


def test_results_changed_by_others_are_a_fault(hknob, spec_file, tmp_path: Path) -> None:
    """Not as the stage writes them, though they say they are its own, of this spec."""
    spec = spec_file(SPEC.replace("phases: 8", "phases: 1"))
    assert hknob("sweep", spec, "-o", "out").returncode == 0
    path = tmp_path / "out" / "cells.parquet"
    table = pq.read_table(path)
    at = table.column_names.index("certified_fraction")
    assert table.schema.metadata.keys() == {KEY, SEAL}
    for other in (table.remove_column(at), table.set_column(at, "certified_fraction", pa.array([HOSTILE]))):
        path.write_bytes(sealed_file(other, table.schema.metadata))
        for options in ((), ("--json",)):
            done = hknob("sweep", spec, "-o", "out", *options)
            assert (done.returncode, done.stdout) == (1, "")
            assert done.stderr.startswith("out: its tables are not as sweep writes them: ")
            assert done.stderr.endswith("; run again with --force\n")
    assert hknob("sweep", spec, "-o", "out", "--force").returncode == 0


def test_numbers_that_no_picture_has_room_for(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file("kind: sysid\nname: cell\nwhat: grip_cell\nvirtual: {}\n")
    assert hknob("sysid", spec, "-o", "cell").returncode == 0
    path = tmp_path / "cell" / "calibration_points.parquet"
    table = pq.read_table(path)
    huge = pa.array([1e308, -1e308] * (table.num_rows // 2) + [0.0] * (table.num_rows % 2))
    other = table.set_column(table.column_names.index("x"), "x", huge)
    path.write_bytes(sealed_file(other, table.schema.metadata))
    done = hknob("report", spec_file("kind: report\nname: page\nresults: {cell: cell}\n"))
    assert done.returncode == 2
    assert "of cell cannot be drawn with {}: overflow" in done.stderr
