"""The identification: recordings read or made, prepared, fitted by every estimator, and combined."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from math import nan
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.apparatus.experiment import Schedule, record_apparatus, record_experiments
from hknob_cli.apparatus.hand_recording import virtual_rig
from hknob_cli.errors import ComputationError, UsageError
from hknob_cli.identify.fit import Estimate, Fit
from hknob_cli.identify.fourth_order import fourth_order
from hknob_cli.identify.identified import at_the_skin, damping_ratio, over_blocks, over_subjects, without_apparatus
from hknob_cli.identify.least_squares import least_squares, least_squares_acceleration, least_squares_friction
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.prepare import Preparation, Prepared, conditions
from hknob_cli.recordings.files import table as recordings_table
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import WRONG_SIGN, Trial
from hknob_cli.results.arrays import build_table
from hknob_cli.specs.identification import SysidPlan
from hknob_cli.stages.sysid import columns
from hknob_cli.stages.sysid.remarks import disagreements, first_reasons

DERIVATIVES = ("least_squares", "least_squares_friction", "least_squares_acceleration")
Progress = Callable[[int, int], None]
Row = dict[str, Any]


class Fitted(NamedTuple):
    """A fit of one motion, its condition, and what it amounts to: parameters of the hand, by name."""

    of: Prepared
    trial: int | None
    fit: Fit
    parameters: dict[str, Estimate]
    skin: dict[str, Estimate]
    flags: tuple[str, ...]


class SysidStage:
    """An identification that is ready to run."""

    def __init__(self, plan: SysidPlan) -> None:
        """Make ready."""
        self.plan = plan
        self.fitted: list[Fitted] = []
        moved = partial(output_error, lag_s=plan.lag_s, coulomb_nm=plan.coulomb_nm, fixed=plan.fixed)
        self._estimators: dict[str, Callable[[Motion], Fit]] = {
            "least_squares": partial(least_squares, fixed=plan.fixed),
            "least_squares_friction": partial(least_squares_friction, fixed=plan.fixed),
            "least_squares_acceleration": partial(least_squares_acceleration, fixed=plan.fixed),
            "output_error": moved,
            "output_error_friction": partial(moved, fit_coulomb=True),
            "fourth_order": partial(fourth_order, inertia=plan.fixed.get("inertia")),
        }

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters that any of the estimators gives, in the order of their columns."""
        given = set(columns.ALWAYS)
        if {"least_squares_friction", "output_error_friction"} & set(self.plan.estimators):
            given.add("coulomb")
        if "fourth_order" in self.plan.estimators:
            given |= {"finger_inertia", "finger_damping", "finger_stiffness", "pad_damping", "pad_stiffness"}
        return tuple(name for name in columns.PARAMETERS if name in given)

    def trials(
        self,
        progress: Progress = lambda _done, _total: None,
        warn: Callable[[str], None] = lambda _text: None,
    ) -> list[Trial]:
        """The recordings; ``progress`` is told of those that are made, ``warn`` of what is surprising in those read.

        Raises `RecordingError`, `UsageError`.
        """
        plan = self.plan
        if plan.virtual is None:
            return read(plan.files, columns=plan.columns, limits=plan.limits, warn=warn)
        virtual = plan.virtual
        rig = virtual_rig(plan)
        if plan.what == "apparatus":
            return record_apparatus(rig, trials=virtual.trials, seed=virtual.seed)
        return record_experiments(
            rig,
            Schedule(virtual.experiments, virtual.subjects, virtual.blocks, virtual.trials, virtual.grips),
            seed=virtual.seed,
            model="fourth" if virtual.model == "fourth" else "second",
            torque=virtual.input,
            progress=progress,
        )

    @property
    def counts(self) -> int | None:
        """Counts per revolution of the encoder that recorded; None if unknown."""
        if self.plan.virtual is not None:
            return virtual_rig(self.plan).counts_per_rev or None
        return self.plan.counts_per_rev

    def run(self, trials: list[Trial], progress: Progress = lambda _done, _total: None) -> tuple[pa.Table, pa.Table]:
        """Fits of every motion, and of every condition.

        Raises `UsageError` where an experiment's name in the spec is misspelt, and `ComputationError` where no trial
        can be used.
        """
        there = list(dict.fromkeys(trial.key.experiment for trial in trials))
        for name, given in (("subtract_apparatus", self.plan.apparatus), ("knob_radius", self.plan.radius)):
            _check_names(name, given, there)
        fitted = self.fitted = list(self._fitted(trials, progress))
        if not any(
            value.identifiable and name not in self.plan.fixed
            for one in fitted
            for name, value in one.fit.parameters.items()
        ):
            raise ComputationError(f"no trial can be used: {first_reasons(one.flags for one in fitted)}")
        return self._trials_table(fitted), self._conditions_table(fitted)

    def _fitted(self, trials: list[Trial], progress: Progress) -> Iterator[Fitted]:
        plan = self.plan.prepare
        motion = self.plan.motion
        both: dict[str, Any] = {"average": plan.average, "window_s": plan.window_s, "span_s": plan.span_s}
        raw = Preparation(decimate=1, differentiate=False, **both, **motion._asdict())
        # Of a pulse the torque is left square, as the dissertation does.
        smooth = Preparation(
            decimate=plan.decimate,
            interpolate=plan.interpolate,
            smooth_torque=motion.continuous,
            **both,
            **motion._asdict(),
        )
        kinds = {name: smooth if name in DERIVATIVES else raw for name in self.plan.estimators}
        motions = {how: conditions(trials, how, counts_per_rev=self.counts) for how in dict.fromkeys(kinds.values())}
        total = sum(len(motions[how]) for how in kinds.values())
        done = 0
        for name, how in kinds.items():
            for one in motions[how]:
                yield self._one(name, one)
                progress(done := done + 1, total)

    def _one(self, name: str, one: Prepared) -> Fitted:
        averaged = self.plan.prepare.average and not self.plan.motion.continuous
        trial = one.trials[0] if not averaged and one.trials else None
        if one.motion is None or any(WRONG_SIGN in flag for flag in one.flags):
            empty = {key: Estimate(nan, nan, False) for key in columns.ALWAYS}
            return Fitted(one, trial, Fit(name, {}, nan), empty, {}, one.flags)
        fit = self._estimators[name](one.motion)
        parameters = dict(fit.parameters)
        flags = [*one.flags, *fit.flags]
        flags += [f"{key} cannot be told" for key, value in parameters.items() if not value.identifiable]
        if {"damping", "stiffness"} <= set(parameters):
            parameters["damping_ratio"] = damping_ratio(fit)
        own = self._of_experiment(self.plan.apparatus, one)
        if own is not None and "inertia" in parameters:
            whole = parameters["inertia"]
            parameters["inertia"], below = without_apparatus(whole, own)
            flags += below
            if whole.identifiable and not parameters["inertia"].identifiable:
                flags.append(f"inertia cannot be told from the apparatus's own: {whole.value:.4g} less {own:.4g}")
        radius = self._of_experiment(self.plan.radius, one)
        moved = {key: parameters[key] for key in columns.SKIN if key in parameters}
        skin = at_the_skin(moved, radius) if radius is not None else {}
        return Fitted(one, trial, fit, parameters, skin, tuple(dict.fromkeys(flags)))

    def apparatus_of(self, one: Prepared) -> float | None:
        """Inertia (kg·m²) that is subtracted as the apparatus' own; None where none is."""
        return self._of_experiment(self.plan.apparatus, one)

    def _of_experiment(self, given: dict[str, float], one: Prepared) -> float | None:
        return given.get(one.condition.experiment, given.get(""))

    def _trials_table(self, fitted: list[Fitted]) -> pa.Table:
        schema = [
            *columns.TRIAL_KEYS,
            columns.ESTIMATOR,
            *columns.parameter_columns(self.names, spread=False, skin=bool(self.plan.radius)),
            columns.APPARATUS,
            *columns.QUALITY,
            columns.AVERAGED,
            columns.DIFFER,
            columns.FLAGS,
        ]
        rows = [
            {
                **one.of.condition._asdict(),
                "trial": one.trial,
                "estimator": one.fit.estimator,
                **self._values(one.parameters, one.skin),
                columns.APPARATUS.name: self._of_experiment(self.plan.apparatus, one.of),
                "vaf": one.fit.vaf,
                "white": one.fit.white,
                "trials": len(one.of.trials),
                columns.DIFFER.name: one.of.motion.trials_differ if one.of.motion else None,
                "flags": "; ".join(one.flags),
            }
            for one in fitted
        ]
        return build_table(schema, rows)

    def _values(self, parameters: dict[str, Estimate], skin: dict[str, Estimate]) -> Row:
        """Values and errors by column; what cannot be told is null, never a number."""
        row: Row = {}
        for names, given, catalogue in (
            (self.names, parameters, columns.PARAMETERS),
            (tuple(columns.SKIN) if self.plan.radius else (), skin, columns.SKIN),
        ):
            for name in names:
                column = catalogue[name][0]
                told = name in given and given[name].identifiable
                row[column] = given[name].value if told else None
                row[f"{column}_std"] = given[name].std if told else None
        return row

    def _conditions_table(self, fitted: list[Fitted]) -> pa.Table:
        schema = [
            *columns.CONDITION_KEYS,
            columns.ESTIMATOR,
            *columns.parameter_columns(self.names, spread=True, skin=bool(self.plan.radius)),
            columns.APPARATUS,
            columns.QUALITY[0],
            columns.AVERAGED,
            columns.FLAGS,
        ]
        people: dict[tuple[str, str, float, str], list[Fitted]] = {}
        for one in fitted:
            condition = one.of.condition
            key = (condition.experiment, condition.subject, condition.grip_target_n, one.fit.estimator)
            people.setdefault(key, []).append(one)
        rows = [self._person(key, group) for key, group in people.items()]
        for row, remark in zip(rows, disagreements(rows), strict=True):
            row["flags"] = "; ".join(part for part in (row["flags"], remark) if part)
        every: dict[tuple[str, float, str], list[Row]] = {}
        for row in rows:
            every.setdefault((row["experiment"], row["grip_target_n"], row["estimator"]), []).append(row)
        return build_table(schema, [*rows, *(self._everybody(group) for group in every.values())])

    def _person(self, key: tuple[str, str, float, str], group: list[Fitted]) -> Row:
        experiment, subject, grip, estimator = key
        means = {name: over_blocks(_told(one.parameters.get(name) for one in group)) for name in self.names}
        skin = {name: over_blocks(_told(one.skin.get(name) for one in group)) for name in columns.SKIN}
        return {
            "level": "subject",
            "experiment": experiment,
            "subject": subject,
            "grip_target_n": grip,
            "estimator": estimator,
            **self._values(means, skin if self.plan.radius else {}),
            columns.APPARATUS.name: self._of_experiment(self.plan.apparatus, group[0].of),
            "vaf": over_subjects(one.fit.vaf for one in group).mean,
            "trials": sum(len(one.of.trials) for one in group),
            "flags": "; ".join(dict.fromkeys(flag for one in group for flag in one.flags)),
        }

    def _everybody(self, group: list[Row]) -> Row:
        """Mean and standard deviation over persons, as Tables 1 to 5 have them."""
        first = group[0]
        row: Row = {
            "level": "all",
            "experiment": first["experiment"],
            "subject": None,
            "grip_target_n": first["grip_target_n"],
            "estimator": first["estimator"],
            columns.APPARATUS.name: first[columns.APPARATUS.name],
            "vaf": over_subjects(_there(one["vaf"] for one in group)).mean,
            "trials": sum(one["trials"] for one in group),
        }
        catalogues = [columns.PARAMETERS[name] for name in self.names]
        catalogues += list(columns.SKIN.values()) if self.plan.radius else []
        for column, _, _ in catalogues:
            spread = over_subjects(_there(one[column] for one in group))
            row[column], row[f"{column}_std"] = spread.mean, spread.std
        doubtful = sum(bool(one["flags"]) for one in group)
        row["flags"] = f"{doubtful} of {len(group)} persons have flags" if doubtful else ""
        return row


def kept_recordings(trials: list[Trial]) -> pa.Table:
    """The recordings as a table, to keep beside what was identified from them."""
    return recordings_table(trials)


def _check_names(name: str, given: dict[str, float], there: list[str]) -> None:
    """Raise `UsageError` where an experiment goes without, and one that is not recorded has it: a name is misspelt."""
    strange = [one for one in given if one and one not in there]
    if strange and not set(there) <= set(given) and "" not in given:
        without = ", ".join(f"'{one}'" for one in there if one not in given)
        raise UsageError(f"{name}: no recording is of experiment '{strange[0]}', and {without} would go without")


def _told(estimates: Iterable[Estimate | None]) -> list[Estimate]:
    return [one for one in estimates if one is not None and one.identifiable]


def _there(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]
