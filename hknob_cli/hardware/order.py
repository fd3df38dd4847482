"""The order of a campaign: every sample rate, resolution and remedy, shuffled by a seed within each repeat."""

import random
from itertools import product
from typing import Any, NamedTuple

from hknob_cli.hardware.port import Settings
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.plan import COUNTS, RATE

BLOCK_S = 0.01  # of samples that travel together
MOST_BLOCK = 48


class Trial(NamedTuple):
    """One trial: its ``number`` from 1 in the order they are run, the repeat (``block``) that it is of, its cell.

    ``remedy``: the name of what it tries; empty in a campaign without remedies.
    """

    number: int
    block: int
    sample_rate_hz: float
    counts_per_rev: int
    remedy: str = ""

    @property
    def label(self) -> str:
        """Name of its files."""
        return f"{self.number:02}_{self.sample_rate_hz:g}_{self.counts_per_rev}"

    @property
    def values(self) -> dict[str, Any]:
        """Its fields by name, as files of a trial have them: without a remedy where there is none."""
        found = self._asdict()
        return found if self.remedy else {name: found[name] for name in found if name != "remedy"}

    def __str__(self) -> str:
        under = f", {self.remedy}" if self.remedy else ""
        return f"trial {self.number} ({self.sample_rate_hz:g} Hz, {self.counts_per_rev} counts{under})"


def trials_of(plan: HwRunPlan) -> tuple[Trial, ...]:
    """Trials of a campaign in the order they are run."""
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


def period_ns(sample_rate_hz: float) -> int:
    """Interval of the sample clock that a device is told."""
    return round(1e9 / sample_rate_hz)


def settings_of(plan: HwRunPlan, trial: Trial) -> Settings:
    """What the device is told for a trial."""
    block = round(trial.sample_rate_hz * BLOCK_S)
    acts = plan.tried(trial.remedy)
    settings = Settings(
        period_ns=period_ns(trial.sample_rate_hz),
        counts_per_rev=trial.counts_per_rev,
        wall_stiffness=acts.wall.stiffness,
        wall_damping=acts.wall.damping,
        torque_limit_nm=plan.limits.torque,
        speed_limit_rad_s=plan.limits.speed,
        watchdog_us=round(plan.limits.watchdog * 1e6),
        block_samples=min(max(block, 1), MOST_BLOCK),
    )
    if acts.controller is None:
        return settings
    from hknob_cli.hardware.control import control_of

    return settings._replace(control=control_of(acts.controller, settings))
