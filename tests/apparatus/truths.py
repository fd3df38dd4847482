"""The hands behind recordings that the apparatus makes."""

from hknob_cli.apparatus.experiment import EVERY, Schedule, key_of, places
from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.apparatus.people import Variation, trial_hand
from hknob_cli.recordings.trial import Key


def truths(schedule: Schedule = EVERY, *, seed: int = 0, variation: Variation | None = None) -> dict[Key, SecondOrder]:
    """The J, B, K behind each trial of `record_experiments`, by its key, for the same arguments."""
    return {key_of(place): trial_hand(place, seed=seed, variation=variation) for place in places(schedule)}
