"""A made-up page of a hundred claims and real figures, for tests and for looking at."""

import base64
import math
from typing import Any

from hknob_cli.figures import theme
from hknob_cli.page.book import Chapter, Clip, Drawn, Head, Page, Source, Table
from hknob_cli.page.claims.verdict import COLUMNS, CONTRADICTED, DIFFERS, NOT_TESTABLE, REPRODUCED
from hknob_cli.page.tables import UPRIGHT
from hknob_cli.perception import sound

MARK = "<!-- hknob page sample -->"
SAYS = (
    "Limit cycle amplitude falls with encoder resolution.",
    "With 1024 counts per revolution at 1 kHz the simulated limit cycle is 3.72 mrad peak to peak, about half of what "
    "the same knob shows with 512 counts, and its frequency hardly changes over the whole range of resolutions that "
    "were tried, from 256 to 4096 counts per revolution.",
    "The constant C is 500, and the law is “nearly identical” to the simulation.",
    "Friction of 0.56 mN·m stops the limit cycle.",
    "One harmonic underestimates the size by 55 ± 15 %.",
)
PLACES = ("sec. 7.3", "Table 7.1", "Fig. 8.2", "eq. (3.12)", "ch. 9", "Table 1", "app. B")


def reading(name: str, computed: float | None, verdict: str, *, excluded: str | None = None) -> dict[str, Any]:
    """A reading as the column ``readings`` has it."""
    return {"name": name, "computed": computed, "verdict": verdict, "missing": "", "excluded": excluded}


READINGS: tuple[tuple[str, list[dict[str, Any]]], ...] = (
    ("stiffness 0.04", [reading("stiffness 0.04", 3.716, REPRODUCED), reading("stiffness 0.08", 0.0, CONTRADICTED)]),
    (
        "half-quantum bias, from 464 Hz up, hand stiffness of Table 1",
        [
            reading("half-quantum bias, from 464 Hz up, hand stiffness of Table 1", -16.2, DIFFERS),
            reading("as printed, over all 49 cells", -23.0, CONTRADICTED),
            reading(
                "amplitude against peak to peak", -58.1, REPRODUCED, excluded="it compares unlike things; see sec. 7.3"
            ),
        ],
    ),
    ("", []),
)


def claim(**values: Any) -> dict[str, Any]:
    """A row of claims.parquet; what is not given is empty."""
    numbers: dict[str, Any] = {"printed": None, "computed": None, "agreeing": 0, "allowed": 0, "readings": []}
    empty = {column.name: numbers.get(column.name, "") for column in COLUMNS}
    return {**empty, "claim": "a", "place": "sec. 1.1", "says": "It buzzes.", "verdict": REPRODUCED, **values}


def claims(count: int = 100) -> tuple[dict[str, Any], ...]:
    """Claims of all sorts: numbers and statements, long and short, with readings and without, in four verdicts."""
    rows = []
    for i in range(count):
        verdict = (REPRODUCED, DIFFERS, REPRODUCED, CONTRADICTED, REPRODUCED, NOT_TESTABLE, REPRODUCED)[i % 7]
        printed = None if i % 9 == 4 else (3.72, 500.0, -55.0, 0.56, 1.9e-6, 12500.0)[i % 6]
        used, readings = READINGS[i % 3]
        tested = verdict != NOT_TESTABLE
        shift = {REPRODUCED: 1.002, DIFFERS: 1.07, CONTRADICTED: 1.6, NOT_TESTABLE: 1.0}[verdict]
        rows.append(
            claim(
                claim=f"{7 + i // 40}.{i % 40 + 1}-{('size', 'pitch', 'constant-of-the-quantum-period-law')[i % 3]}",
                place=PLACES[i % len(PLACES)],
                says=SAYS[i % len(SAYS)],
                printed=printed,
                computed=None if not tested else (printed or 1.0) * shift * (1 + i / 1e4),
                unit=("mrad", "", "%", "mN·m", "kg·m²", "Hz")[i % 6],
                reading=used if tested else "",
                verdict=verdict,
                tolerance="holds: within 5 %; differs: within 10 %" if tested else "",
                because="three digits are printed" if tested else "the recording is not published",
                agreeing=1 if tested else 0,
                allowed=2 if tested else 0,
                data="main-grid, predict" if tested else "",
                readings=readings if tested else [],
                finding="Trials choose among coexisting cycles, and a mean is one number for them all."
                if i % 4
                else "",
                check="mean_size" if tested else "",
                figure=("sizes", "grid", "", "hardware", "bias")[i % 5],
            )
        )
    return tuple(rows)


def _lines(name: str, title: str, *, panels: int = 1, height: float = 3.2) -> str:
    figure = theme.figure(height=height)
    for axes in figure.subplots(1, panels, squeeze=False)[0]:
        for i in range(5):
            xs = [0.05 * n for n in range(1, 120)]
            axes.plot(
                xs,
                [math.sin(x * (1 + i / 4)) / (1 + x / 4) + i / 3 for x in xs],
                label=f"{256 << i}",
                **theme.series(i),
            )
        axes.set_xlabel("time, ms")
        axes.set_ylabel("angle, mrad")
        axes.legend(title="counts", ncols=2)
    return theme.svg(figure, name=name, title=title, mark=MARK)


def _map(name: str, title: str) -> str:
    figure = theme.figure(height=3.4)
    axes = figure.subplots()
    values = [[math.hypot(i - 2, j - 3) for i in range(7)] for j in range(7)]
    shown = axes.imshow(values, cmap=theme.MAP, aspect="auto", origin="lower")
    axes.grid(visible=False)
    for j, row in enumerate(values):
        for i, value in enumerate(row):
            axes.text(i, j, f"{value:.1f}", ha="center", color=theme.ON_LIGHT if value > 2.5 else theme.ON_DARK)
    axes.set_xlabel("sample rate, Hz")
    axes.set_ylabel("counts per revolution")
    figure.colorbar(shown, label="peak to peak, mrad")
    return theme.svg(figure, name=name, title=title, mark=MARK)


def _points(name: str, title: str) -> str:
    figure = theme.figure(height=3.0, width=4.2)
    axes = figure.subplots()
    for i in range(4):
        axes.plot([1, 2, 3, 4], [(i + 1) / n for n in (1, 2, 3, 4)], label=f"method {i + 1}", **theme.points(i))
    axes.set_xlabel("resolution, 1000 counts")
    axes.set_ylabel("error, %")
    axes.legend()
    return theme.svg(figure, name=name, title=title, mark=MARK)


def _drawn(name: str, title: str, svg: str, *results: str) -> Drawn:
    caption = (
        "Each line is one encoder resolution. Size falls with resolution, pitch hardly does; from 464 Hz up the law "
        "stays within 20 % of the proven cycles, and below it the wall acts over many counts."
    )
    return Drawn(name, title, caption, svg, f"{title}: five lines that fall from left to right.", results)


def _cells() -> Table:
    """A table that is wider and longer than its box."""
    names = ("sample rate", "encoder", "peak to peak, largest cycle", "its frequency", "peak to peak", "frequency")
    units = ("Hz", "counts per revolution", "mrad", "Hz", "mrad", "Hz")
    heads = [Head(name, unit, f"what is meant by {name}", False) for name, unit in zip(names, units, strict=True)]
    heads += [Head("proven", "", "", True), Head("reason", "", "why it is not certified", True)]
    why = "the motion neither repeats nor comes to rest within the samples that it was followed for"
    rows = tuple(
        (f"{100 * (i + 1)}", "1024", f"{8.123 / (i + 1):.4g}", "83.33", "3.107", "80", "no" if i % 5 else "yes", why)
        for i in range(40)
    )
    notes = ("The same in every row: at rest 0 %; diverged 0 %.", "cells.parquet has further columns: p2p_counts.")
    title = "main-grid: cells"
    return Table("table-cells", title, "40 of 1,234 rows of cells.parquet.", tuple(heads), rows, notes, ("main-grid",))


def _one_cell() -> Table:
    """A table of one row."""
    rows = (
        ("sample rate", "1000 Hz", "sample rate of the controller"),
        ("peak to peak", "2.305 mrad", "mean peak minus mean trough, mean of the trials that cycle"),
        ("reason", "no damping: nothing makes the motion settle", "why it is not certified; empty where it is"),
    )
    return Table("table-one", "predict: the one cell", "The one row of cells.parquet.", UPRIGHT, rows, (), ("predict",))


def page(count: int = 100) -> Page:
    """The whole sample."""
    text = (
        "Which cycle a trial reaches depends on when it is first sampled, so a cell's answer is a set of orbits with "
        "their shares. The “irregularities” of simulated frequency plots are this.",
        "The pitch is a staircase. Over the user's push, the period steps through ratios of whole samples to whole "
        "cycles, highest at half a count's torque.",
    )
    sizes = _drawn(
        "sizes", "Size over resolution", _lines("sizes", "Size over resolution", panels=2), "main-grid", "predict"
    )
    grid = _drawn("grid", "Every cell of the grid", _map("grid", "Every cell of the grid"), "main-grid")
    bias = _drawn("bias", "Pitch over the user's push", _lines("bias", "Pitch over push"), "bias staircase", "lost")
    tone = sound.clip([100.0], [1e-3], duration_s=0.1, rate_hz=8000)
    address = f"data:audio/wav;base64,{base64.b64encode(sound.wav_bytes(tone)).decode()}"
    bias = bias._replace(clips=(Clip("A low hum", address), Clip("The same again", address)))
    error = _drawn("error", "Error of four methods", _points("error", "Error of four methods"), "predict")
    hardware = Drawn(
        "hardware", "The recorded hardware", "What the rig did.", "", "", (), "recordings.parquet is not there"
    )
    spec = {"kind": "sweep", "name": "main-grid", "scene": {"wall": {"stiffness": 0.27}}, "starts": {"phases": 64}}
    sources = tuple(
        Source(name, stage, (f"results/{i}/cells.parquet", f"results/{i}/orbits.parquet"), f"{i}c0ffee" * 8, over, spec)
        for i, (name, stage, over) in enumerate(
            [
                ("main-grid", "sweep", ()),
                ("bias staircase", "sweep", ("scene.bias.torque=0.001",)),
                ("predict", "predict", ()),
            ]
        )
    )
    return Page(
        name="sample",
        title="What a dissertation says of limit cycles, computed again",
        sentences=(
            "Of 100 numbers and statements, 57 come back, 14 differ, 15 do not hold, and 14 cannot be tested.",
            "With the printed hand stiffness the knob rests where the text says that it buzzes; with the stiffness of "
            "its own Table 1 every cell buzzes.",
            "Every cycle here is proven: the motion between samples is exact, and its certificate is checked.",
        ),
        lead=("sizes", "grid", "bias", "unknown"),
        claims=claims(count),
        claims_of="C. J. Hasser's dissertation",
        chapters=(
            Chapter("size", "Size and resolution", text, (sizes, grid), (_cells(), _one_cell())),
            Chapter("pitch", "Pitch and push", text[1:], (bias, error)),
            Chapter("rig", "The rig", (), (hardware,)),
        ),
        sources=sources,
        rerun=("make sweep", "hknob page experiments/page.yaml --set name=again"),
        versions={"hknob": "0.5.0", "numpy": "2.3.4", "Python": "3.11.2"},
        mark=MARK,
    )
