"""The order of a campaign: every sample rate, resolution and remedy, shuffled by a seed within each repeat."""

import random
from itertools import product
from typing import Any, NamedTuple

from hknob_cli.hardware.port import Settings
from hknob_cli.hardware.wire.answers import MOST_SAMPLES, most_samples
from hknob_cli.recordings.trial import Key
from hknob_cli.specs.campaign import HwRunPlan, Model
from hknob_cli.specs.controller import MODELLED, Controller
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.pulses import PulsePlan

BLOCK_S = 0.01  # of samples that travel together
USUAL_GRIP_N = 0.71  # Chapter 8's target


class Trial(NamedTuple):
    """One trial: its ``number`` from 1 in the order they are run, the repeat (``block``) that it is of, its cell.

    ``remedy``: the name of what it tries; empty in a campaign without remedies. ``grip_target_n``: of a pulse, N, 0
    in a campaign without pulses; then no encoder is coarser than the device's own, and ``counts_per_rev`` is 1.
    """

    number: int
    block: int
    sample_rate_hz: float
    counts_per_rev: int
    remedy: str = ""
    grip_target_n: float = 0.0

    @property
    def label(self) -> str:
        """Name of its files."""
        if self.grip_target_n:
            return f"{self.number:02}_{self.grip_target_n:g}N"
        return f"{self.number:02}_{self.sample_rate_hz:g}_{self.counts_per_rev}"

    @property
    def values(self) -> dict[str, Any]:
        """Its fields by name, as files of a trial have them: without a remedy or a grip where there is none."""
        found = self._asdict()
        return {name: value for name, value in found.items() if value or name not in ("remedy", "grip_target_n")}

    def __str__(self) -> str:
        if self.grip_target_n:
            return f"trial {self.number} ({self.grip_target_n:g} N, block {self.block})"
        under = f", {self.remedy}" if self.remedy else ""
        return f"trial {self.number} ({self.sample_rate_hz:g} Hz, {self.counts_per_rev} counts{under})"


def trials_of(plan: HwRunPlan | PulsePlan) -> tuple[Trial, ...]:
    """Trials of a campaign in the order they are run."""
    if isinstance(plan, PulsePlan):
        return _pulse_trials(plan)
    chance = random.Random(plan.seed)  # whose random() is the same in every version of Python
    found: list[Trial] = []
    for repeat in range(1, plan.repeats + 1):
        cells = list(product(plan.axes[RATE], plan.axes[COUNTS], [one.name for one in plan.tries]))
        if plan.shuffled:
            keys = [chance.random() for _ in cells]
            cells = [cells[i] for i in sorted(range(len(cells)), key=keys.__getitem__)]
        for rate, counts, remedy in cells:
            found.append(Trial(len(found) + 1, repeat, float(rate), int(counts), remedy))
    return tuple(found)


def _pulse_trials(plan: PulsePlan) -> tuple[Trial, ...]:
    """Trials of each block: the lightest grip first, or shuffled by the seed."""
    chance = random.Random(plan.seed)
    found: list[Trial] = []
    for block in range(1, plan.repeats + 1):
        grips = [grip for grip in plan.grips for _ in range(plan.pulses.trials)]
        if plan.shuffled:
            keys = [chance.random() for _ in grips]
            grips = [grips[i] for i in sorted(range(len(grips)), key=keys.__getitem__)]
        for grip in grips:
            found.append(Trial(len(found) + 1, block, plan.pulses.sample_rate, 1, grip_target_n=grip))
    return tuple(found)


def key_of(plan: HwRunPlan | PulsePlan, trial: Trial) -> Key:
    """What tells its recording from others."""
    target = trial.grip_target_n or (plan.course.grip_target_n if isinstance(plan, HwRunPlan) else 0.0)
    return Key(plan.subject, plan.experiment, target, trial.block, trial.number)


def period_ns(sample_rate_hz: float) -> int:
    """Interval of the sample clock that a device is told."""
    return round(1e9 / sample_rate_hz)


def settings_of(plan: HwRunPlan | PulsePlan, trial: Trial) -> Settings:
    """What the device is told for a trial."""
    block = round(trial.sample_rate_hz * BLOCK_S)
    if isinstance(plan, PulsePlan):
        from hknob_cli.hardware.person import order_of

        return Settings(
            period_ns=period_ns(trial.sample_rate_hz),
            counts_per_rev=trial.counts_per_rev,
            wall_stiffness=0.0,
            wall_damping=0.0,
            torque_limit_nm=plan.limits.torque,
            speed_limit_rad_s=plan.limits.speed,
            watchdog_us=round(plan.limits.watchdog * 1e6),
            block_samples=min(max(block, 1), MOST_SAMPLES),
            pulse=order_of(plan, trial.grip_target_n),
        )
    acts = plan.tried(trial.remedy)
    settings = Settings(
        period_ns=period_ns(trial.sample_rate_hz),
        counts_per_rev=trial.counts_per_rev,
        wall_stiffness=acts.wall.stiffness,
        wall_damping=acts.wall.damping,
        torque_limit_nm=plan.limits.torque,
        speed_limit_rad_s=plan.limits.speed,
        watchdog_us=round(plan.limits.watchdog * 1e6),
        block_samples=min(max(block, 1), MOST_SAMPLES),
    )
    if acts.encoder or acts.actuator:
        from hknob_cli.hardware.trial_wall import converters_of

        settings = settings._replace(converters=converters_of(acts.encoder, acts.actuator))
    if plan.effects:
        from hknob_cli.hardware.control import over_angle_of

        return settings._replace(over_angle=over_angle_of(plan.effects, settings))
    if acts.controller is None:
        return settings
    from hknob_cli.hardware.control import control_of, looks_of

    control = control_of(acts.controller, settings, _model_of(plan, acts.controller))
    # A block of the wire has less room for samples where readings are beside them; for more than it has, none.
    most = most_samples(len(looks_of(control))) or MOST_SAMPLES
    return settings._replace(control=control, block_samples=min(settings.block_samples, most))


def _model_of(plan: HwRunPlan, controller: Controller) -> Model:
    """Knob and hand as a controller with a model believes them to be; unless a spec says so, as simulated ones are."""
    from hknob_cli.hardware.control import UNKNOWN

    if controller.kind not in MODELLED:
        return UNKNOWN
    if plan.model is not None:
        return plan.model
    from hknob_cli.hardware.person import hand_at

    hand = hand_at(plan.course.grip_target_n or USUAL_GRIP_N)
    knob = plan.driven.knob
    return Model(knob.inertia + hand.inertia, knob.damping + hand.damping, hand.stiffness)
