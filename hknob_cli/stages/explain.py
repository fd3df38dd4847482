"""What a spec of each kind of stage describes, in words: by its plan, without computing results."""

from collections.abc import Callable
from typing import Any

from hknob_cli.report.derived_numbers import derived_numbers, passivity
from hknob_cli.report.scene_words import Explained, scene_sentences
from hknob_cli.report.table import short
from hknob_cli.specs.capabilities import ESTIMATED, parts_of, verdict_of
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import Axes, Cell, Scene, SweepPlan, is_unpushed, may_have, scene_at
from hknob_cli.specs.remarks import not_proven, unusual
from hknob_cli.stage_table import STAGES, loaded
from hknob_cli.stages.explain_parts import explained_campaign, grid_lines, size, starts_lines, who
from hknob_cli.stages.work import counted

_UNPUSHED = "nothing pushes the knob into the wall: where it rests, it may buzz under a push"
_MOST_NAMES = 12


def explain(kind: str, plan: Any, command: str) -> Explained:
    """What a valid spec describes; ``command``: how to run it."""
    answer, sections, scene, axes = EXPLANATIONS[kind](plan) if kind in EXPLANATIONS else _of_its_row(kind, plan)
    preset = getattr(plan, "preset", None)
    sections["preset"] = [line.strip() for line in preset.lines if "left out:" not in line] if preset else []
    if preset:
        sections.setdefault("ignored", []).extend(f"left out by the preset: {one}" for one in preset.left_out)
    sections["warnings"] = unusual(plan)
    numbers = derived_numbers(scene, axes) if scene else []
    return Explained(kind, plan.name, answer, sections, numbers, command)


Found = tuple[str, dict[str, list[str]], Scene | None, Axes]


def _sweep(plan: SweepPlan) -> Found:
    about = {
        **_about(plan.scene, plan.axes),
        "grid": grid_lines(plan),
        "starts": starts_lines(plan.starts, plan.scene),
        "not proven": [f"{text[0].upper()}{text[1:]}." for text in not_proven(plan)],
        "ignored": _ignored(plan),
        "asked as well": _asked(plan),
        "work": _work(plan),
    }
    answer = f"{size(plan)} asks whether {who(plan.scene)} buzzes, how much and at what pitch."
    return answer, about, plan.scene, plan.axes


def _dfa(plan: Any) -> Found:
    ignored = []
    pushed = [name for name in ("sampled", "staircase") if name == "sampled" or name in plan.methods]
    if not (plan.scene.bias and plan.scene.bias.half_quantum) and not set(plan.methods) <= set(pushed):
        but = " and ".join(f"`{name}`" for name in pushed)
        ignored = [f"The push, by all methods but {but}: they assume half of the torque step of one count."]
    about = {
        **_about(plan.scene, plan.axes),
        "grid": grid_lines(plan),
        "methods": [f"{', '.join(plan.methods)}.", *_against(plan.against)],
        "not proven": ["Describing functions and Tsypkin's locus estimate. Only a sweep proves what is found."],
        "ignored": ignored,
    }
    answer = f"{size(plan)} asks which limit cycles {len(plan.methods)} frequency-response methods predict"
    return f"{answer} where {who(plan.scene)} meets the wall.", about, plan.scene, plan.axes


def _predict(plan: Any) -> Found:
    about = {
        **_about(plan.scene, plan.axes),
        "grid": grid_lines(plan),
        "laws": [f"{', '.join(plan.laws)}.", *_constant(plan), *_against(plan.against)],
        **({"criteria": [f"{', '.join(plan.criteria)}."]} if plan.criteria else {}),
        "not proven": ["Closed laws estimate. The column in_domain says where the assumptions of each hold."],
        "ignored": _outside(plan),
    }
    answer = f"{size(plan)} asks what {counted(len(plan.laws), 'closed law')} and the stability limits say"
    return f"{answer} where {who(plan.scene)} meets the wall.", about, plan.scene, plan.axes


def _remedies(plan: Any) -> Found:
    reference = next(one for one in plan.remedies if one.name == plan.reference)
    sweep = reference.grid
    about = {
        **_about(sweep.scene, sweep.axes),
        "grid": grid_lines(sweep),
        "hands": [f"{', '.join(plan.hands[:_MOST_NAMES])}{_and_more(len(plan.hands))}."],
        "cases": [f"{name}: {short(rate)} Hz, {counts} counts per revolution." for name, rate, counts in plan.cases],
        "remedies": [_remedy(one, plan.reference) for one in plan.remedies],
        "starts": starts_lines(sweep.starts, sweep.scene),
        "not proven": _not_proven_of([one.grid for one in plan.remedies]),
        "ignored": _unpushed(sweep.scene, sweep.axes),
    }
    answer = f"{counted(len(plan.remedies), 'remedy', 'remedies')} are compared with '{plan.reference}' for"
    asked = f"{counted(len(plan.hands), 'hand')} over {_lower(size(sweep))}: how large is the buzz that is left,"
    return f"{answer} {asked} and how stiff is the wall?", about, sweep.scene, sweep.axes


def _remedy(one: Any, reference: str) -> str:
    needs = f": needs {one.needs}" if one.needs else ""
    tuned = f"; tunes {one.tunes} over {len(one.tuned)} values" if one.tunes else ""
    return f"{one.name}{' (the reference)' if one.name == reference else ''}{needs}{tuned}."


def _choice(one: Any) -> str:
    options = (f"{option.label or short(option.value)} (cost {short(option.cost)})" for option in one.options)
    return f"{one.name}: {', '.join(options)}."


def _design(plan: Any) -> Found:
    sweep = next(one.sweep for one in plan.candidates if one.name == plan.reference)
    axes = {**sweep.axes, **{one.name: [option.value for option in one.options] for one in plan.choices}}
    limits = [f"the wall renders at least {short(plan.stiffness)} N*m/rad"] if plan.stiffness is not None else []
    for what, limit in (("touch", plan.touch), ("hearing", plan.hearing)):
        if limit:
            above = "the present design" if limit.above_present else "the threshold"
            limits.append(
                f"{what}: at most {short(100.0 * limit.people)} % of the people have a level more than "
                f"{short(limit.most_db)} dB above {above}"
            )
    if plan.torque_step_db is not None:
        limits.append(f"torque steps: at most {short(plan.torque_step_db)} dB")
    about = {
        **_about(sweep.scene, axes),
        "choices": [_choice(one) for one in plan.choices],
        "remedies": [f"{one.name} (cost {short(one.cost)})." for one in plan.candidates],
        "limits": [f"{one[0].upper()}{one[1:]}." for one in limits],
        "starts": starts_lines(sweep.starts, sweep.scene),
        "not proven": _not_proven_of([one.sweep for one in plan.candidates]),
        "ignored": _unpushed(sweep.scene, sweep.axes),
    }
    answer = f"Which of {counted(plan.size, 'design')} is the cheapest that keeps {counted(len(limits), 'limit')}"
    return f"{answer} for {counted(plan.people, 'hand')}?", about, sweep.scene, axes


def _sysid(plan: Any) -> Found:
    if plan.study:
        asked = [name for name in ("bias", "hidden") if getattr(plan.study, name)]
        what = {"bias": "how far off the estimators are", "hidden": "what a second-order fit takes for the inertia"}
        return f"A study asks {' and '.join(what[one] for one in asked)}, on simulated recordings.", {}, None, {}
    source = f"{counted(len(plan.recordings), 'recording')}" if plan.recordings else "a simulated apparatus"
    about = {
        "recordings": [f"{path}." for path in plan.recordings],
        "estimators": [f"{', '.join(plan.estimators)}."],
        "apparatus": [
            f"Inertia {short(value)} kg*m^2 is taken off{f' in experiment {name}' if name else ''}."
            for name, value in plan.apparatus.items()
            if value
        ],
        "not proven": ["Estimates have error bars; they are not proven."],
    }
    if one := plan.virtual:
        grips = f", at grips of {', '.join(map(short, one.grips))} N" if one.grips else ""
        people = f"{counted(one.subjects, 'subject')}" if one.subjects else "the subjects of the dissertation"
        driven = f" The torque is a {one.input.kind} of {short(one.input.duration_s)} s." if one.input else ""
        about["recordings"] = [
            f"Simulated: experiments {', '.join(map(str, one.experiments))}, {people}, {counted(one.blocks, 'block')} "
            f"of {counted(one.trials, 'trial')}{grips}, seed {one.seed}.{driven}"
        ]
    return f"The {str(plan.what).replace('_', ' ')} is identified from {source}.", about, None, {}


def _bench(plan: Any) -> Found:
    about = {
        "scenes": [_scene(one) for one in plan.scenes],
        "methods": [f"{', '.join(plan.methods)}."],
        "not proven": ["Run times depend on the machine and differ from run to run."],
    }
    answer = f"{counted(len(plan.methods), 'method')} compute the same {counted(len(plan.scenes), 'trial')}:"
    return f"{answer} how large is the error of each, and how long does it take?", about, None, {}


def _scene(one: Any) -> str:
    counts = f"{one.counts_per_rev} counts" if one.counts_per_rev else "no counts"
    return f"{one.name}: {short(one.sample_rate_hz)} Hz, {counts}, {one.samples} samples, against {one.reference}."


def _report(plan: Any) -> Found:
    from pathlib import Path

    missing = [folder for folder in plan.results.values() if not Path(folder).is_dir()]
    about = {
        "results": [f"{name}: {folder}." for name, folder in plan.results.items()],
        "chapters": [f"{one.title}." for one in plan.chapters],
        "claims": [f"Judged by these results: {plan.claims}."] if plan.claims else [],
        "missing": [f"{folder} is not there yet." for folder in missing],
    }
    answer = f"{counted(len(plan.results), 'result')} {'are' if len(plan.results) > 1 else 'is'} put on one page"
    return f"{answer}{', with the verdicts of a ledger of claims' if plan.claims else ''}.", about, None, {}


EXPLANATIONS: dict[str, Callable[[Any], Found]] = {
    "sysid": _sysid,
    "sweep": _sweep,
    "dfa": _dfa,
    "predict": _predict,
    "remedies": _remedies,
    "design": _design,
    "hw-run": explained_campaign,
    "bench": _bench,
    "report": _report,
}


def _of_its_row(kind: str, plan: Any) -> Found:
    """What the table of stages says of a kind that has no explanation of its own, and how much there is to do."""
    row = STAGES[kind]
    return row.summary, {"work": [f"{loaded(row.work).size(plan)}."]}, None, {}


def _about(scene: Scene, axes: Axes) -> dict[str, list[str]]:
    return {"parts": scene_sentences(scene, axes), "passivity": passivity(scene, axes)}


def _lower(text: str) -> str:
    return text[0].lower() + text[1:]


def _ends(plan: Any) -> list[tuple[Scene, Cell]]:
    """The first and the last cell, each with its scene."""
    cells = cells_of(plan)
    return [(scene_at(plan.scene, cell), cell) for i in (0, len(cells) - 1) for cell in cells.run(i, i + 1)]


def _unpushed(scene: Scene, axes: Axes) -> list[str]:
    return [f"{_UNPUSHED[0].upper()}{_UNPUSHED[1:]}."] if is_unpushed(scene, axes) else []


def _ignored(plan: SweepPlan) -> list[str]:
    scene, axes = plan.scene, plan.axes
    found = _unpushed(scene, axes)
    against = may_have(scene, axes, "wall.stiffness")
    over_angle = scene.profile or scene.detents or scene.end_stops or scene.dead_zone
    if not against and not over_angle and scene.bias:
        found.append("There is no wall to push against, so that the push has nothing to balance it but the hand.")
    return found


def _asked(plan: SweepPlan) -> list[str]:
    found = []
    if plan.perceive:
        where = f"{short(1e3 * plan.perceive.knob_radius)} mm from the axis"
        found.append(f"Who feels it: levels of touch {where}, by the thresholds {plan.perceive.thresholds}.")
    if plan.record:
        found.append(f"Recordings: {short(plan.record.duration)} s of {counted(plan.record.trials, 'trial')} a cell.")
    if plan.growth_s:
        found.append(f"Growth: how the energy of bounces grows over {short(plan.growth_s)} s.")
    if plan.basins:
        found.append(f"Basins: which start ends where, {plan.basins} x {plan.basins} starts a cell.")
    return found


def _work(plan: SweepPlan) -> list[str]:
    """How much work it is, as far as the program knows beforehand; seconds depend on the machine."""
    from hknob_cli.stages.sweep.run import COMPILE_ABOVE, SweepStage

    if plan.scene.controller:
        return ["Not known beforehand: trials with controllers last until they are proven."]
    stage = SweepStage(plan)
    samples = sum(stage.expected.values())
    if not samples:
        return []
    how = "the engine may be compiled first, once for each machine and user"
    if samples < COMPILE_ABOVE and set(stage.expected) <= {"plain", "bounces"}:
        how = "few enough to run without compiling"
    elif stage.spreads:
        how = "processes share the work, and a run that is cut short goes on where it was"
    return [f"About {float(f'{samples:.1g}'):,.0f} trial-samples: {how}."]


def _against(folder: str | None) -> list[str]:
    return [f"Compared with the sweep in {folder}."] if folder else []


def _constant(plan: Any) -> list[str]:
    return [f"The quantum-period law has the constant {short(plan.constant)} 1/s."] if plan.constant else []


def _outside(plan: Any) -> list[str]:
    """Parts that laws only estimate."""
    found = []
    for scene, _ in _ends(plan):
        parts = [part for part in sorted(parts_of(scene)) if part in ("virtual_damping", "friction")]
        if parts and verdict_of(parts, "formulas")[0] == ESTIMATED:
            found.append("Virtual damping and friction, by laws that lack them: in_domain then says so.")
    return list(dict.fromkeys(found))


def _not_proven_of(plans: list[SweepPlan]) -> list[str]:
    found = dict.fromkeys(text for plan in plans for text in not_proven(plan))
    return [f"For some remedies {text}." for text in found]


def _and_more(count: int) -> str:
    return f" and {count - _MOST_NAMES} more" if count > _MOST_NAMES else ""
