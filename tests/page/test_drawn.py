"""Tests of `page.drawn`: figures by one process and by several; clips on a page, which are loud by one factor.

Clips are made of recordings and play without a request to a server. A motion that has not settled has no clip.
"""

import base64
import io
import wave
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.figures import draw, theme
from hknob_cli.figures.recording import settled_period
from hknob_cli.page import drawn
from hknob_cli.page.drawn import DURATION_S, RATE_HZ, clips, draw_figures
from hknob_cli.page.layout import lay_out
from hknob_cli.recordings.spectrum import recorded_harmonics
from hknob_cli.results.provenance import describe
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.results.store import write
from hknob_cli.specs.load import load
from hknob_cli.specs.report import validate_report
from hknob_cli.specs.source import parse
from hknob_cli.specs.stage_plans import FigurePlan, Listen, Sentence
from hknob_cli.stages.sweep.record import record_sweep
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import EXPERIMENTS
from tests.page.opened import Opened
from tests.page.sample import page

MANY = 3  # figures, of which several processes draw one or two
BOTH = (Listen("coarse", "coarse"), Listen("fine", "fine"))


@pytest.fixture(scope="module")
def evidence(tmp_path_factory: pytest.TempPathFactory) -> ResultSet:
    """A light contact at two resolutions, and one whose recording ends before it is steady."""
    folder = tmp_path_factory.mktemp("recorded")
    asked = {"coarse": (1000, 0.5), "fine": (2650, 0.5), "short": (2650, 0.02)}
    for name, (counts, duration) in asked.items():
        changes = [f"grid.counts_per_rev={counts}", f"record.duration={duration}", "starts.phases=2", f"name={name}"]
        plan: Any = load(EXPERIMENTS / "light_contact.yaml", changes)
        found = SweepStage(plan).run()
        tables = {"cells": found.cells, "orbits": found.orbits, "trajectories": record_sweep(plan)}
        provenance = describe(stage="sweep", values=plan.values, overrides=())
        (folder / name).mkdir()
        write({folder / name / f"{file}.parquet": table for file, table in tables.items()}, provenance)
    return ResultSet({name: folder / name for name in asked})


def samples(address: str) -> np.ndarray:
    head, data = address.split(",")
    assert head == "data:audio/wav;base64"
    with wave.open(io.BytesIO(base64.b64decode(data))) as stream:
        assert (stream.getnchannels(), stream.getsampwidth(), stream.getframerate()) == (1, 2, RATE_HZ)
        return np.frombuffer(stream.readframes(stream.getnframes()), dtype="<i2").astype(float)


def test_the_period_is_that_of_a_proven_cycle_and_closes(evidence: ResultSet) -> None:
    period = settled_period(evidence, "fine")
    n = {row["period_samples"] for row in evidence["fine"].rows("orbits")}
    assert round((period.time[-1] - period.time[0]) * 1000.0) in n
    assert period.velocity[0] == pytest.approx(period.velocity[-1], abs=1e-3 * np.ptp(period.velocity))
    # Two times 12 or 14 samples of 1 ms, and the transient, do not fit into 20 ms.
    with pytest.raises(MissingError, match="'short' ends before it repeats itself"):
        settled_period(evidence, "short")


def test_one_factor_serves_all(evidence: ResultSet) -> None:
    coarse, fine = (samples(clip.address) for clip in clips(evidence, BOTH))
    assert len(coarse) == len(fine) == round(DURATION_S * RATE_HZ)
    loudest = max(np.abs(coarse).max(), np.abs(fine).max())
    assert loudest == pytest.approx(0.5 * 32767, abs=1.0)
    speeds = [np.abs(settled_period(evidence, name).velocity).max() for name in ("coarse", "fine")]
    # The harmonics above 8 kHz that a clip leaves out make the corners of speed rounder, by less than 1 %.
    assert np.abs(coarse).max() / np.abs(fine).max() == pytest.approx(speeds[0] / speeds[1], rel=0.01)


def test_its_pitch_is_the_cycles(evidence: ResultSet) -> None:
    heard = samples(clips(evidence, BOTH)[1].address)
    spectrum = np.abs(np.fft.rfft(heard * np.hanning(len(heard))))
    period = settled_period(evidence, "fine")
    motion = recorded_harmonics(period.time, period.velocity, highest_hz=1000.0)
    strongest = motion.frequency_hz[motion.speed_rad_s.argmax()]
    assert abs(spectrum.argmax() / DURATION_S - strongest) <= 1.0 / DURATION_S


def test_clips_are_small_and_the_same_every_time(evidence: ResultSet) -> None:
    found = clips(evidence, BOTH)
    assert found == clips(evidence, BOTH)
    assert all(len(clip.address) < 60_000 for clip in found)
    assert clips(evidence, ()) == ()


def test_cycles_and_their_harmonics_are_drawn(evidence: ResultSet) -> None:
    options = {"names": ["a coarse one", "a fine one"]}
    one, two = (
        theme.svg(draw("cycle_spectra", evidence, ["coarse", "fine"], options), name="x", title="") for _ in range(2)
    )
    assert one == two
    for text in ("a coarse one", "a fine one", "time, ms", "frequency of the harmonic, Hz", "peak speed, mrad/s"):
        assert text in one
    with pytest.raises(MissingError, match="2 recordings, but 1 names"):
        draw("cycle_spectra", evidence, ["coarse", "fine"], {"names": ["one"]})


def planned(evidence: ResultSet, draws: list[str]) -> list[FigurePlan]:
    return [
        FigurePlan(f"fig-{i}", name, tuple(evidence.names[:2]), {"names": ["a", "b"]}, "t", Sentence("{x}", {}), "")
        for i, name in enumerate(draws)
    ]


def test_several_processes_draw_what_one_does_in_its_order(
    evidence: ResultSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawn, "FEW", MANY)
    figures = planned(evidence, ["cycle_spectra"] * MANY)
    figures[1] = figures[1]._replace(of=("fine", "short"))  # which has no picture, and says why
    found, counted = [], []
    for jobs in (1, 2):
        done: list[int] = []
        found.append(draw_figures(figures, evidence, "", jobs=jobs, progress=lambda n, _, done=done: done.append(n)))
        counted.append(done)
    assert found[0] == found[1]
    assert [one.id for one in found[1]] == [one.id for one in figures]
    assert "ends before it repeats itself" in found[1][1].missing
    assert all(one.svg for i, one in enumerate(found[1]) if i != 1)
    assert all(some == sorted(some) and some[-1] == MANY for some in counted)


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_figure_that_cannot_be_drawn_ends_all_of_them(
    evidence: ResultSet, jobs: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawn, "FEW", MANY)
    figures = planned(evidence, ["cycle_spectra"] * MANY)
    figures[2] = figures[2]._replace(options={"names": 3}, where="report.yaml:7:5")
    with pytest.raises(UsageError, match=r"^report\.yaml:7:5: cycle_spectra of coarse, fine cannot be drawn"):
        draw_figures(figures, evidence, "", jobs=jobs, progress=lambda *_: None)
    assert not active_children()


def test_a_spec_may_ask_for_clips_and_says_what_is_wrong() -> None:
    text = (
        "kind: report\nname: a\nresults: [x]\nchapters:\n- title: t\n  figures:\n"
        "  - {id: fig-a, draw: grip_forces, title: t, caption: c, listen: [%s]}\n"
    )
    plan = validate_report(parse(text % "{name: a hum, of: x, at: {trial: 3}}", "a.yaml"))
    assert plan.chapters[0].figures[0].listen == (Listen("a hum", "x", (("trial", 3.0),)),)
    with pytest.raises(SpecError, match="listen"):
        validate_report(parse(text % "{name: a hum, from: x}", "a.yaml"))


def test_clips_can_be_played_by_keyboard_and_the_page_may_ask_for_nothing_else(browser: Any, tmp_path: Path) -> None:
    text = lay_out(page())
    policy = text.split('http-equiv="Content-Security-Policy" content="')[1].split('"')[0]
    assert policy.startswith("default-src 'none';")
    assert "media-src data:;" in policy
    outside = '<audio id="outside" src="https://example.org/a.wav" preload="auto"></audio></main>'
    path = tmp_path / "page.html"
    path.write_text(text.replace("</main>", outside), encoding="utf-8")
    with Opened(browser, path.as_uri()) as opened:
        tab = opened.tab
        players = tab.locator("figure audio")
        assert players.count() == 2
        tab.wait_for_function("[...document.querySelectorAll('figure audio')].every(one => one.readyState >= 1)")
        assert tab.eval_on_selector_all("figure audio", "all => all.map(one => one.duration)") == [0.1, 0.1]
        assert tab.get_by_label("A low hum").count() == 1
        players.first.focus()
        assert tab.evaluate("document.activeElement === document.querySelector('figure audio')")
        # The policy stops the request before it is made, and the console says so.
        assert not [url for url in opened.asked if url.startswith("https:")]
        assert any("example.org" in said and "media-src data:" in said for said in opened.said)
