"""Tests of `report.scene_words`: no number of a part is left out of what is said of it."""

import pytest

from hknob_cli.report.scene_words import scene_sentences
from hknob_cli.specs.parts import Actuator, Encoder, Knob, Scene, Wall
from hknob_cli.specs.scene_paths import scalar_paths

PARTS = ("knob", "wall", "encoder", "actuator")
SCENE = Scene(Knob(1e-6), Wall(0.2), encoder=Encoder(), actuator=Actuator())


@pytest.mark.parametrize("path", [path for path in scalar_paths() if path.startswith(PARTS)])
def test_a_number_is_said(path: str) -> None:
    part, key = path.split(".")
    scene = SCENE._replace(**{part: getattr(SCENE, part)._replace(**{key: 0.123})})
    assert "0.123" in " ".join(scene_sentences(scene, {}))
    assert "0.125 to 0.375" in " ".join(scene_sentences(SCENE, {path: [0.125, 0.375]}))


def test_numbers_that_no_form_has_come_last_by_their_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hknob_cli.report.scene_words._Words._clock", lambda words: iter([words._forms("actuator")]))
    scene = SCENE._replace(actuator=Actuator(torque_limit=0.2, dead_band=0.003))
    assert "torque limit 0.2 N*m, dead band 0.003 N*m" in scene_sentences(scene, {})
