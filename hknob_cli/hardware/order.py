"""The trials of a campaign: their order and settings, and the ranges of these that a target and the wire take.

Every sample rate, resolution and remedy is tried, shuffled by a seed within each repeat. A simulated knob and person
have ranges, too.
"""

import random
from itertools import product
from math import inf, isfinite
from typing import Any, NamedTuple

from hknob_cli.hardware.control import begins_of, looks_of, pulse_of, senses_speed
from hknob_cli.hardware.port import MOST_SINES, Identity, Settings, Simulated
from hknob_cli.hardware.trial_wall import MOST, room_of
from hknob_cli.hardware.wire.answers import MOST_SAMPLES, most_samples
from hknob_cli.hardware.wire.codes import Law
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


# A block must come well before silence counts as a dead link.
LONGEST_BLOCK_S = 0.05
LONGEST_PULSE_NS = 500_000_000
MOST_LOOKS = 63  # readings of a target within an interval
MOST_OVER_ANGLE = 16_640  # counts of a table


def faults_of_settings(settings: Settings, identity: Identity) -> list[str]:
    """What is wrong with settings, one text a value; empty if nothing is. Source: `docs/reference/wire.md`."""
    ranges = {
        "period_ns": (identity.shortest_period_ns, 1_000_000_000),
        "counts_per_rev": (1, identity.native_counts),
        "wall_stiffness": (0.0, 1e3),
        "wall_damping": (0.0, 1e3),
        "torque_limit_nm": (0.0, 10.0),
        "speed_limit_rad_s": (0.0, 1e4),
        "watchdog_us": (1000, 50_000),
        "block_samples": (1, 48),
    }
    above = ("torque_limit_nm", "speed_limit_rad_s")
    found = []
    for name, (least, most) in ranges.items():
        value = getattr(settings, name)
        if not least <= value <= most or (name in above and value == 0.0):
            allowed = f"above {least:g}, at most {most:g}" if name in above else f"from {least:g} to {most:g}"
            found.append(f"{name} must be {allowed}, got {value:.10g}")
    found += [*_faults_of_control(settings, identity), *_faults_of_converters(settings, identity)]
    found += _faults_over_angle(settings, identity)
    return found or _faults_of_pulse(settings, identity)


def _faults_of_control(settings: Settings, identity: Identity) -> list[str]:
    """What of a controller a target does not have."""
    control = settings.control
    if control is None:
        return []
    if not identity.knows_control:
        return ["it runs the plain wall alone, no controller: it does not know CONTROL (docs/reference/wire.md)"]
    found = []
    law = Law(control.law)
    if not identity.laws & law.bit:
        name = law.name.lower()
        found.append(f"it does not have the controller {name}: its firmware is older (docs/reference/wire.md)")
    if len(begins_of(control)) > 1 and not identity.knows_parts:
        found.append(
            "its torque does not change within a sample interval: its firmware is older (docs/reference/wire.md)"
        )
    if senses_speed(control) and not identity.knows_speed:
        found.append("it has no sensor of the speed: only the virtual device has")
    if looks_of(control) and not identity.knows_looks:
        found.append("it reads its encoder once a sample: its firmware is older (docs/reference/wire.md)")
    return found


def _faults_of_converters(settings: Settings, identity: Identity) -> list[str]:
    """Whether a target rounds and delays, and has room for the torques that are under way."""
    converters = settings.converters
    if converters is None:
        return []
    found = []
    if not identity.knows_converters:
        found.append(
            "it rounds down, and sends every torque at once: it does not know CONVERTERS (docs/reference/wire.md)"
        )
    parts = 1 if settings.over_angle is not None else len(begins_of(settings.control))
    if room_of(parts, converters.delay_samples) > MOST:
        found.append(
            f"the delay takes {room_of(parts, converters.delay_samples)} torques that are under way, and a target "
            f"has room for {MOST}"
        )
    return found


def _faults_over_angle(settings: Settings, identity: Identity) -> list[str]:
    """Whether a target has a torque over the angle, and room for its table."""
    if settings.over_angle is None:
        return []
    found = []
    if not identity.knows_over_angle:
        found.append(
            "it runs the plain wall alone, no torque over the angle: it does not know OVER_ANGLE "
            "(docs/reference/wire.md)"
        )
    if (count := len(settings.over_angle.torques)) > MOST_OVER_ANGLE:
        found.append(
            f"the torque over the angle takes a table of {count} counts, and a target has room for "
            f"{MOST_OVER_ANGLE}: choose fewer counts, or nearer ends"
        )
    return found


def _faults_of_pulse(settings: Settings, identity: Identity) -> list[str]:
    """What is wrong with a torque pulse beside settings that are right."""
    pulse = settings.pulse
    if pulse is None:
        return []
    found = []
    if not identity.knows_pulses:
        found.append("it fires no pulses: it does not know PULSE (docs/reference/wire.md)")
    if not 0.0 < pulse.torque_nm <= settings.torque_limit_nm:
        most = settings.torque_limit_nm
        found.append(f"the pulse must be above 0, at most {most:g} N m, got {pulse.torque_nm:.10g}")
    if not (pulse_of(pulse, settings.interval_s).width - 1) * settings.period_ns < LONGEST_PULSE_NS:
        found.append(f"the pulse must last at most {LONGEST_PULSE_NS * 1e-9:g} s, got {pulse.width_s:.10g}")
    return found


def faults_of_simulated(simulated: Simulated) -> list[str]:
    """What is wrong with a simulated knob and person, one text a value; empty if nothing is."""
    faults = []
    sines = (*simulated.push_sines, *simulated.grip_sines)
    plain = simulated._replace(push_sines=(), grip_sines=())._asdict()
    numbers = {name: value for name, value in plain.items() if not isinstance(value, tuple)}
    for name, value in numbers.items():
        least = -inf if name in ("angle_rad", "push_nm", "grip_offset_n") else 0.0
        if not isfinite(value) or value < least or (name == "inertia" and value == 0.0):
            allowed = "> 0" if name == "inertia" else ">= 0" if least == 0.0 else "finite"
            faults.append(f"{name} must be {allowed}, got {value:g}")
    if not all(isfinite(value) for sine in sines for value in sine):
        faults.append("sines must be finite")
    if max(len(simulated.push_sines), len(simulated.grip_sines)) > MOST_SINES:
        faults.append(f"at most {MOST_SINES} sines of push and of grip each")
    return faults


def faults(settings: Settings, identity: Identity) -> list[str]:
    """What is out of range for this device, one text for each value."""
    found = faults_of_settings(settings, identity)
    looks = len(looks_of(settings.control))
    if not found and looks > MOST_LOOKS:
        found.append(f"it reads its encoder at most {MOST_LOOKS + 1} times a sample, not {looks + 1} times")
    if not found and settings.block_samples > (most := most_samples(looks)):
        found.append(f"block_samples: a block with {looks} readings beside each sample has at most {most} samples")
    block_s = settings.block_samples * settings.interval_s
    if not found and block_s > LONGEST_BLOCK_S:
        longest = LONGEST_BLOCK_S * 1e3
        found.append(f"block_samples: a block must take at most {longest:g} ms, these take {block_s * 1e3:g} ms")
    return found
