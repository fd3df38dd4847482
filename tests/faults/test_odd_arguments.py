"""Odd paths, names and quantities: clear words, and no long wait."""

import os
from pathlib import Path

import pytest

from hknob_cli.specs import quantity
from hknob_cli.specs.quantity import to_si

LONG = "n" * 260


@pytest.mark.parametrize("command", ["check", "sweep", "run", "explain"])
def test_a_pipe_is_no_spec(command: str, hknob, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    done = hknob(command, "pipe.yaml")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "pipe.yaml: is a pipe, where a YAML file is wanted\n"


@pytest.mark.parametrize("command", ["sweep", "run"])
def test_no_name_is_no_folder(command: str, hknob, spec_file, tmp_path: Path) -> None:
    done = hknob(command, spec_file(), "-o", "")
    assert (done.returncode, done.stdout) == (2, "")
    assert "Invalid value for '--out' / '-o': is empty; must name a folder" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["spec.yaml"]


def test_names_that_no_file_can_have(hknob, spec_file, tmp_path: Path) -> None:
    assert hknob("sweep", spec_file(), "-o", "grid").returncode == 0
    report = spec_file(f"kind: report\nname: page\nresults: {{{LONG}: grid}}\n", "report.yaml")
    pipeline = spec_file(f"kind: pipeline\nname: p\nstages: {{{LONG}: {{spec: spec.yaml}}}}\n", "pipeline.yaml")
    for command, spec in (("report", report), ("check", report), ("run", pipeline)):
        done = hknob(command, spec)
        assert (done.returncode, done.stdout) == (2, "")
        assert "at most 80 " in done.stderr
    done = hknob("sweep", spec_file(), "-o", LONG)
    assert (done.returncode, done.stdout) == (1, "")
    assert "File name too long" in done.stderr


def test_each_unit_is_parsed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    quantity._factor.cache_clear()
    asked = []
    registry = quantity._registry()
    monkeypatch.setattr(quantity, "_registry", lambda: asked.append(1) or registry)
    texts = [f"{i} mN*m/rad" for i in range(1000)]
    found = [to_si(text, "N*m/rad") for text in texts]
    assert found == [float(registry.Quantity(float(i), "mN*m/rad").to("N*m/rad").magnitude) for i in range(1000)]
    assert 0 < len(asked) < 10
    for _ in range(2):
        with pytest.raises(ValueError, match="unknown unit 'foo'"):
            to_si("1 foo", "N")
    assert quantity._factor.cache_info().misses == 2
