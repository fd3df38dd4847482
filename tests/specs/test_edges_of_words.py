"""What is said of a spec at the edge of each rule, and what is kept of it."""

import io
import re
import sys
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from pydantic.fields import FieldInfo

from hknob_cli.errors import Fault, SpecError, UsageError
from hknob_cli.specs.campaign import Course, Grip, Person
from hknob_cli.specs.capabilities import EXACT, PROVEN, REFUSED, parts_of, verdict_of
from hknob_cli.specs.hand import HandSpec, hand_contradictions
from hknob_cli.specs.hand_from import label
from hknob_cli.specs.load import _kind_fault, load, load_text, spec_model, validate
from hknob_cli.specs.messages import message, shown
from hknob_cli.specs.named_file import STDIN, all_named, given, inside
from hknob_cli.specs.over_angle import EndStops
from hknob_cli.specs.parquet import why_unreadable
from hknob_cli.specs.part import _default
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.pipeline import _input_fault
from hknob_cli.specs.plan import Encoder, Finger, Fingerpad, Hand, Knob, Scene, SweepPlan, Wall
from hknob_cli.specs.pulses import PulsePlan
from hknob_cli.specs.refusals import _within
from hknob_cli.specs.scene_paths import unknown_path
from hknob_cli.specs.seal import _TAIL, tail_of
from hknob_cli.specs.source import parse, span_of
from hknob_cli.specs.stage_plans import ReportPlan
from hknob_cli.specs.starter import _comment, _named, starter
from hknob_cli.specs.sweep import RANDOM, StartsSpec
from hknob_cli.specs.tried import ActingSpec, acting_faults
from hknob_cli.specs.virtual_apparatus import VirtualSpec
from tests.conftest import SPEC
from tests.hardware.campaigns import REMEDIES, planned
from tests.hardware.campaigns import SPEC as BENCH

PULSES = "kind: hw-run\nname: p\nwhat: pulses\npulses: {grips: [0.71], trials: 2}\n"


def faults(text: str, *overrides: str) -> list[Fault]:
    """Faults of a spec."""
    with pytest.raises(SpecError) as caught:
        load_text(text, "spec.yaml", overrides)
    return caught.value.faults


@pytest.mark.parametrize(
    ("kind", "allowed", "said"),
    [
        (None, ["sweep"], "missing, and required; must be sweep"),
        (None, ["sweep", "dfa"], "missing, and required; one of: sweep, dfa"),
        ("sweeep", ["sweep"], "must be sweep, got 'sweeep'"),
        ("sweeep", ["sweep", "dfa"], "must be one of: sweep, dfa; got 'sweeep'; did you mean 'sweep'?"),
        (3, ["sweep", "dfa"], "must be one of: sweep, dfa; got 3"),
    ],
)
def test_what_is_said_of_a_kind(kind: Any, allowed: list[str], said: str) -> None:
    assert _kind_fault(kind, allowed) == said


def test_an_override_that_is_no_text_has_no_line() -> None:
    (fault,) = faults(SPEC, "name=\udc80")
    assert (fault.line, fault.column, fault.message) == (0, 0, "must be key.path=value in UTF-8")


def test_an_unknown_key_of_a_pipeline_may_be_one_of_its_stages() -> None:
    text = "kind: pipeline\nname: p\nstages: {knob: {spec: knob.yaml}}\n"
    (fault,) = faults(text, "starts.phases=4")
    assert "did you mean 'stages.knob.set.starts.phases'?" in fault.message


def test_an_unknown_key_may_be_each_that_ends_like_it() -> None:
    said = unknown_path(spec_model("sweep"), "stiffness")
    assert said is not None
    assert said.startswith("unknown key; did you mean 'scene.")
    assert said.partition("?")[0].count(" or ") == 2
    assert str(unknown_path(spec_model("sweep"), "pulse.durtion")).startswith(
        "unknown key; did you mean 'record.pulse.duration'?"
    )
    assert str(unknown_path(spec_model("sweep"), "punch.duration")).startswith(
        "unknown key; did you mean 'record.pulse.duration'?"
    )
    assert "did you mean 'base.scene.hand.fingerpad.damping'?" in str(
        unknown_path(spec_model("bench"), "fingerpad.damping")
    )
    assert str(unknown_path(spec_model("sweep"), "zzzzzzzz")).startswith("unknown key; allowed: kind, ")


def test_sixty_letters_are_shown() -> None:
    assert shown("a" * 58) == f"'{'a' * 58}'"
    assert shown("a" * 59) == f"'{'a' * 56}..."


def test_the_yaml_that_cannot_be_read_at_all_is_at_its_begin() -> None:
    (fault,) = faults("kind: sweep\nname: \x01\n")
    assert (fault.line, fault.column) == (1, 1)
    assert fault.message == "not YAML: unacceptable character #x0001: special characters are not allowed"


def test_what_the_parser_was_reading_is_said_in_brackets() -> None:
    (fault,) = faults("a: [1\n")
    assert fault.message == "not YAML: expected ',' or ']', but got '<stream end>' (while parsing a flow sequence)"


@pytest.mark.parametrize("text", ["a: 1", "a: [1, 2]"])
def test_no_key_is_within_a_value(text: str) -> None:
    with pytest.raises(KeyError):
        span_of(text, ("a", "b"))


def test_end_stops_at_one_angle_are_none() -> None:
    assert EndStops(1.0, 0.5, 0.5).wrong() == "low must be below high, got 0.5 and 0.5"
    assert EndStops(1.0, 0.4, 0.5).wrong() == ""


def test_a_default_that_is_a_part_is_made_anew() -> None:
    made = _default(Person())
    assert isinstance(made, FieldInfo)
    assert made.default_factory is not None
    assert made.get_default(call_default_factory=True) == Person()
    assert _default(3.0) == 3.0


@pytest.mark.parametrize(
    ("knob", "pad", "finger", "damped"),
    [(*dampings, any(dampings)) for dampings in product((0.0, 1e-3), repeat=3)],
)
def test_dampers_of_finger_and_pad_add(knob: float, pad: float, finger: float, *, damped: bool) -> None:
    hand = Hand(
        finger=Finger(inertia=1e-6, damping=finger, stiffness=1.0), fingerpad=Fingerpad(damping=pad, stiffness=1.0)
    )
    scene = Scene(
        knob=Knob(inertia=1e-6, damping=knob), wall=Wall(stiffness=1.0), hand=hand, encoder=Encoder(), bias=None
    )
    assert ("undamped" not in parts_of(scene)) is damped


def test_gains_at_two_frequencies_are_right() -> None:
    points = ((10.0, 1.0), (100.0, 2.0))
    assert Perceive(0.02, sound_response=points).wrong() == ""
    assert Perceive(0.02, sound_gain=1.0).wrong() == ""
    assert (
        Perceive(0.02, sound_response=points, sound_gain=1.0).wrong().startswith("sound_response: must be absent where")
    )


def test_an_input_from_no_stage_is_wrong() -> None:
    assert _input_fault({"from": []}, "page", ["knob"]) == "must be {from: STAGE}, a list of stages, or all, got []"
    assert _input_fault({"from": ["knob"]}, "page", ["knob"]) is None


def test_nuisances_of_pulses_are_kept() -> None:
    plan = validate(parse(PULSES + "nuisances: {jitter: 1e-6}\n", "spec.yaml"))
    assert isinstance(plan, PulsePlan)
    assert plan.nuisances.jitter == 1e-6


@pytest.mark.parametrize("size", [0, 5, _TAIL, _TAIL + 1])
def test_the_tail_of_a_file(size: int, tmp_path: Path) -> None:
    data = bytes(i % 251 for i in range(size))
    (tmp_path / "file").write_bytes(data)
    assert tail_of(tmp_path / "file") == data[-_TAIL:]


@pytest.mark.parametrize("closed", [True, False])
def test_a_spec_on_standard_input_that_is_not_there(monkeypatch: pytest.MonkeyPatch, *, closed: bool) -> None:
    stream = io.TextIOWrapper(io.BytesIO(b"abc"))
    stream.close()
    monkeypatch.setattr(sys, "stdin", stream if closed else None)
    with pytest.raises(UsageError, match=r"^<stdin>: is closed; give a spec on it, or name a file$"):
        given.__wrapped__(3)


def test_a_byte_more_than_may_be_there_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"abcdef")))
    assert given.__wrapped__(3) == b"abcd"


def test_the_comment_beside_a_name_stays_where_it_was() -> None:
    found = re.match(r"name: \S+ +(?=#)", "name: my-sweep            # of the folder")
    assert found is not None
    assert _named(found, "a knob.yaml") == "name: my-a-knob".ljust(len(found[0]))
    assert _named(found, "a very long name of a knob.yaml") == "name: my-a-very-long-name-of-a-knob "


def test_ranges_of_starts_have_a_middle() -> None:
    starts = StartsSpec(angle=(0.1, 0.4), velocity=(-1.0, 3.0)).plain()
    assert (starts.angle, starts.velocity) == (0.25, 1.0)


def test_a_controller_that_is_wrong_is_said_to_be_on_a_device() -> None:
    acting = ActingSpec(wall={"stiffness": 1.0}, controller={"kind": "velocity_damping"})
    said = acting_faults(acting, frozenset({"kind"}), {}, driver="virtual")
    assert said == [(("controller",), "must have damping where kind is velocity_damping")]


def test_a_grip_twice_is_one() -> None:
    assert VirtualSpec(grips=[1.0, 2.0, 1.0]).plain().grips == (1.0, 2.0)
    assert VirtualSpec().plain().grips is None


def test_the_lightest_knob_of_a_grid_decides() -> None:
    text = SPEC.replace("hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}", "hand: {table: 1, grip_n: 0.71}")
    text = text.replace("  bias:", "  squeeze: {friction: 0.5, radius: 0.01}\n  bias:")
    assert not any("squeeze" in one.key for one in faults_or_none(text))
    light = text.replace("grid:", "grid:\n  knob.inertia: [3.0e-7, 1.9e-5]")
    (fault,) = (one for one in faults_or_none(light) if "squeeze" in one.key)
    assert fault.key == "scene.squeeze"
    assert fault.message == (
        "must leave an inertia above 0: the table takes up to 3.1e-07 kg*m^2 from the 3e-07 of the knob"
    )


def faults_or_none(text: str) -> list[Fault]:
    """Faults of a spec; none where it is good."""
    try:
        load_text(text, "spec.yaml", ())
    except SpecError as error:
        return error.faults
    return []


def test_what_a_campaign_is_held_against_is_kept() -> None:
    plan = planned(BENCH + REMEDIES + "reference: plain wall\nagainst: somewhere\nhand: pinch\n")
    assert (plan.against, plan.hand) == ("somewhere", "pinch")


def test_grips_of_a_hand_that_is_yet_to_be_made_are_not_looked_at() -> None:
    spec = HandSpec.model_validate({"from": "made/conditions.parquet"})
    assert hand_contradictions(spec, 1e-6, {"hand.grip_n": [1.0]}) == []


def test_a_grip_at_the_edge_of_its_band_is_held() -> None:
    course = Course(grip=Grip(target=0.75, band=0.25))
    assert [course.is_held(grip) for grip in (0.49, 0.5, 1.0, 1.01)] == [False, True, True, False]
    assert Course(grip=None).is_held(7.0)


def test_one_stage_of_a_kind_is_read_and_two_are_not(tmp_path: Path) -> None:
    (tmp_path / "knob.yaml").write_text(SPEC)
    (tmp_path / "pages.yaml").write_text("kind: pipeline\nname: p\nstages: {knob: {spec: knob.yaml}}\n")
    assert load(tmp_path / "pages.yaml", kind="sweep").name == "small"
    (tmp_path / "pages.yaml").write_text(
        "kind: pipeline\nname: p\nstages: {knob: {spec: knob.yaml}, other: {spec: knob.yaml}}\n"
    )
    with pytest.raises(SpecError, match=r"is a pipeline; hknob run runs it\. Specs of its sweep stages: .*, .*knob"):
        load(tmp_path / "pages.yaml", kind="sweep")


def test_a_place_within_one_that_is_refused_is_not_said_again() -> None:
    place = ("scene", "wall", "damping")
    assert _within(place, [(("scene", "wall"), "")])
    assert not _within(place, [(("scene",), ""), (("scene", "hand"), "")])


def test_how_many_starts_are_drawn_is_kept() -> None:
    assert StartsSpec(angle=(0.1, 0.4), velocity=(-1.0, 3.0), random=7).plain().phases == 7
    assert StartsSpec(angle=(0.1, 0.4), velocity=(-1.0, 3.0)).plain().phases == RANDOM


def test_a_squeeze_without_a_push_asks_for_nothing() -> None:
    text = SPEC.replace("hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}", "hand: {table: 1, grip_n: 0.71}")
    text = text.replace("  bias: {torque: 0.001}\n", "  squeeze: {friction: 0.5, radius: 0.01}\n")
    assert not any("must ask for at most" in one.message for one in faults_or_none(text))


def test_a_controller_without_a_model_goes_with_an_elastic_gear() -> None:
    gear = "gear: {ratio: 8, motor_inertia: 1.0e-8, stiffness: 10}\n  wall:"
    for kind, refused in (("bounded_lag, keep: 0.5", False), ("matched_wall", True)):
        text = SPEC.replace("  wall:", f"  controller: {{kind: {kind}}}\n  {gear}")
        said = "must be one without a model of knob and hand where the gear has a stiffness"
        assert any(one.message.startswith(said) for one in faults_or_none(text)) is refused


@pytest.mark.parametrize(("least", "said"), [(1, "at least 1 item, got a list of 0"), (2, "at least 2 items, got ")])
def test_how_many_items_a_list_must_have(least: int, said: str) -> None:
    error = {"type": "too_short", "ctx": {"min_length": least}, "input": [], "loc": ("a",)}
    assert message(error, []).startswith(f"must have {said}")


def test_the_first_reason_is_a_part_that_is_always_there() -> None:
    assert verdict_of(["jitter", "undamped"], "general") == (EXACT, "nothing that damps the knob")


def test_pairs_that_one_engine_refuses_are_not_refused_elsewhere() -> None:
    pair = ["hysteresis", "virtual_damping"]
    assert verdict_of(pair, "general") == (REFUSED, "hysteresis of the encoder with virtual damping")
    assert verdict_of(pair, "laws")[0] == PROVEN


REPORT = """\
kind: report
name: small-page
results: [results/small]
chapters:
  - title: One
    figures:
      - {id: fig-a, draw: attractors, of: small, title: A figure, caption: Seen.}
"""


def test_a_page_without_more_words_has_those_of_its_spec() -> None:
    plan = load_text(REPORT, "page.yaml")
    assert isinstance(plan, ReportPlan)
    (figure,) = plan.chapters[0].figures
    assert (plan.title, figure.alt, plan.rerun) == ("small-page", "A figure", ("hknob report page.yaml",))
    text = REPORT.replace("Seen.", "Seen., alt: Two lines").replace("results:", "title: Page\nrerun: [make]\nresults:")
    plan = load_text(text, "page.yaml")
    assert isinstance(plan, ReportPlan)
    (figure,) = plan.chapters[0].figures
    assert (plan.title, figure.alt, plan.rerun) == ("Page", "Two lines", ("make",))


def test_names_in_the_summary_of_a_page_have_values() -> None:
    (fault,) = faults(REPORT + "summary: [{text: 'It is {size}.', values: {}}]\n")
    assert (fault.key, fault.message) == ("summary[0]", "'size' has no value")
    for name in ("size:.2f", "size!r", "size.real"):
        (fault,) = faults(REPORT + f"summary: [{{text: 'It is {{{name}}}.', values: {{}}}}]\n")
        assert fault.message.startswith("must have {names} of letters, digits and '_' only, got {size")


def test_names_in_a_caption_have_values() -> None:
    values = "values: {size: {check: dfa_ratio, with: {}}}"
    text = REPORT.replace("caption: Seen.", f"caption: 'It is {{size}}.', {values}")
    assert load_text(text, "page.yaml").name == "small-page"
    (fault,) = faults(text.replace("It is {size}.", "It is so."))
    assert (fault.key, fault.message) == ("chapters[0].figures[0]", "'size' is not in the text")


def test_claims_are_beside_the_spec_of_a_page(tmp_path: Path) -> None:
    (tmp_path / "claims.yaml").write_text("claims: []\n")
    (tmp_path / "page.yaml").write_text(REPORT + "claims: claims.yaml\n")
    plan = load(tmp_path / "page.yaml")
    assert isinstance(plan, ReportPlan)
    assert (plan.claims, plan.contents) == (str(tmp_path / "claims.yaml"), None)


def test_one_stage_of_a_kind_is_read_beside_others(tmp_path: Path) -> None:
    (tmp_path / "knob.yaml").write_text(SPEC)
    (tmp_path / "laws.yaml").write_text(SPEC.replace("kind: sweep", "kind: predict").partition("starts")[0])
    (tmp_path / "pages.yaml").write_text(
        "kind: pipeline\nname: p\nstages: {laws: {spec: laws.yaml}, knob: {spec: knob.yaml}}\n"
    )
    assert load(tmp_path / "pages.yaml", kind="sweep").name == "small"


def test_a_part_that_is_wrong_as_a_whole_is_not_shown() -> None:
    error = {"type": "two_keys", "msg": "must have both", "loc": ("hand",)}
    assert [message({**error, "input": value}, []) for value in ({"table": 1}, HandSpec(), 1.5)] == [
        "must have both", "must have both", "must have both, got 1.5",
    ]  # fmt: skip


def test_a_name_that_is_too_long_is_said_shortly(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r": File name too long$") as caught:
        inside(tmp_path / ("a" * 300), "cells.parquet")
    assert "[Errno" not in str(caught.value)


def test_standard_input_is_named_among_files() -> None:
    assert all_named([Path("-"), Path("a.yaml")]) == [Path(STDIN), Path("a.yaml")]


def test_why_a_file_cannot_be_read() -> None:
    assert why_unreadable(OSError(2, "No such file or directory")) == "cannot be read: No such file or directory"
    assert why_unreadable(OSError("odd")) == why_unreadable(ValueError("odd")) == "cannot be read"


def test_detents_beside_pulses_are_all_that_is_wrong() -> None:
    assert [str(one) for one in faults(PULSES + "detents: {per_revolution: 12, torque: 0.01}\n")] == [
        "spec.yaml:5:1: detents: must be absent with what: pulses: it is of a buzz"
    ]


def test_words_of_a_comment_are_not_broken() -> None:
    assert _comment(f"a {'x' * 200} b")[1].strip("# ") == "x" * 200


def test_a_starter_says_what_its_preset_has() -> None:
    text = starter("sweep", "smartknob")
    scene = load_text("kind: sweep\nname: a\nscene: {from: smartknob}\ngrid: {}\n", "a.yaml")
    assert isinstance(scene, SweepPlan)
    assert f"# wall.stiffness = {scene.scene.wall.stiffness}\n" in text
    rates, counts = scene.axes["sample_rate_hz"], scene.axes["counts_per_rev"]
    assert f"# grid: {{sample_rate_hz: {rates[0]:g}, counts_per_rev: {counts[0]}}} " in text


def test_whose_row_it_is() -> None:
    row = {"experiment": "1", "grip_target_n": 0.71, "estimator": "output_error"}
    assert label({**row, "subject": "s1"}) == "subject s1, experiment 1, 0.71 N, output_error"
    assert label({**row, "subject": None}) == "the mean over persons, experiment 1, 0.71 N, output_error"
