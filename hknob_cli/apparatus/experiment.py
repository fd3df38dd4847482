"""The five experiments, recorded: subjects, grips, blocks and trials as in Chapters 4 and 5."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

from hknob_cli.apparatus.hand import Hand, SecondOrder, split
from hknob_cli.apparatus.hand_recording import PEAK_RAD, record_trial, scaled_input, scaled_pulse
from hknob_cli.apparatus.people import EXPERIMENTS, Place, Variation, grips, mean_hand, numbers, trial_hand
from hknob_cli.apparatus.rig import Rig
from hknob_cli.apparatus.streams import Purpose, stream
from hknob_cli.errors import UsageError
from hknob_cli.recordings.trial import Array, Key, Trial
from hknob_cli.specs.identification import InputPlan

Subjects = int | Sequence[int] | None


class Schedule(NamedTuple):
    """Which trials are recorded: by default those of the dissertation.

    ``subjects``: how many in every experiment, or their numbers from 1; None: as printed, 9 in the first and 5 in the
    others. ``grips`` (N): of those in the tables; None: all six.
    """

    experiments: Sequence[int] = (1, 2, 3, 4, 5)
    subjects: Subjects = None
    blocks: int = 3
    trials: int = 3
    grips: Sequence[float] | None = None


EVERY = Schedule()


def record_experiments(
    rig: Rig,
    schedule: Schedule = EVERY,
    *,
    seed: int = 0,
    variation: Variation | None = None,
    model: Literal["second", "fourth"] = "second",
    torque: InputPlan | None = None,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> list[Trial]:
    """Record trials, ordered by experiment, subject, block, grip (the lightest first) and trial, as they were run.

    What is left out of a schedule changes nothing of the rest.

    Args:
        rig: what records them.
        schedule: which trials.
        seed: of all that is random.
        variation: how hands differ between people, blocks and trials; None: as printed.
        model: "fourth" gives the hand finger and fingerpad of its own (`split`).
        torque: an input in place of the pulse, recorded to its end.
        progress: is told of the trials recorded, and of how many.

    Raises:
        UsageError: for what is not in the tables, or numbers below 1.
    """
    every = list(places(schedule))
    recorded: list[Trial] = []
    for place in every:
        progress(len(recorded), len(every))
        hand = _held(trial_hand(place, seed=seed, variation=variation), place, rig, model)
        chance = stream(seed, Purpose.RECORDING, *numbers(place))
        push = scaled_pulse(place.experiment, place.grip_n) if torque is None else _input(torque, place, rig)
        until = rig if torque is None else replace(rig, after_s=torque.duration_s)
        recorded.append(record_trial(until, hand, push, key_of(place), chance))
    return recorded


def _input(torque: InputPlan, place: Place, rig: Rig) -> Array:
    return scaled_input(torque, mean_hand(place.experiment, place.grip_n), rig.interval_s, PEAK_RAD)


def key_of(place: Place) -> Key:
    """Key of the trial at a place: subject "S1", "S2", ..., experiment "1" to "5"."""
    return Key(f"S{place.subject}", str(place.experiment), place.grip_n, place.block, place.trial)


def places(schedule: Schedule) -> Iterator[Place]:
    """Every trial's place, in the order in which they are run. Raises `UsageError` for numbers below 1."""
    experiments, subjects, blocks, trials, chosen = schedule
    if blocks < 1 or trials < 1:
        raise UsageError(f"blocks and trials must be >= 1, got {blocks} and {trials}")
    for experiment in experiments:
        forces = grips(experiment) if chosen is None else tuple(sorted(chosen))
        for subject in _subjects(experiment, subjects):
            for block in range(1, blocks + 1):
                for grip in forces:
                    for trial in range(1, trials + 1):
                        yield Place(experiment, subject, grip, block, trial)


def _subjects(experiment: int, subjects: Subjects) -> Sequence[int]:
    if subjects is None:
        subjects = EXPERIMENTS[experiment].subjects
    if isinstance(subjects, int):
        subjects = range(1, subjects + 1)
    if not subjects or min(subjects) < 1:
        raise UsageError(f"subjects must be numbers from 1, at least one, got {list(subjects)}")
    return subjects


def _held(hand: SecondOrder, place: Place, rig: Rig, model: str) -> Hand:
    if model == "second":
        return hand
    small = EXPERIMENTS[place.experiment].knob_mm < 20.0
    return split(hand, knob_kg_m2=rig.small_knob_kg_m2 if small else rig.medium_knob_kg_m2)
