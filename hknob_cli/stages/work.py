"""What a stage does: the parts of its work, the files that it reads, and what several stages share."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hknob_cli.results import provenance
from hknob_cli.results.versions import grid_versions
from hknob_cli.specs.parts import Origin
from hknob_cli.specs.plan import Hand
from hknob_cli.stage_table import STAGES
from hknob_cli.stages.job import Job
from hknob_cli.terminal import say


def _measured(plan: Any) -> Iterator[tuple[Hand, Origin]]:
    """Hands of a plan that say where they are from."""
    scenes = (one.scene for one in plan.scenes) if hasattr(plan, "scenes") else (getattr(plan, "scene", None),)
    for scene in scenes:
        if scene is not None and scene.hand is not None and scene.hand.origin is not None:
            yield scene.hand, scene.hand.origin


def hand_files(plan: Any) -> tuple[Path, ...]:
    """Files that the hands of a plan are from, each once."""
    return tuple(dict.fromkeys(origin.file for _, origin in _measured(plan) if origin.file))


def hand_inputs(plan: Any) -> dict[str, str]:
    """Digests of the files, the numbers of the hand, which a spec with a file does not say, and what was said of them.

    Numbers are JSON with inertia, damping and stiffness in SI units, as `ResultSet.scene` reads them.
    """
    said = {"hand_notes": " ".join(hand_notes(plan))} if hand_notes(plan) else {}
    return {**_digests(plan), **said}


def _digests(plan: Any) -> dict[str, str]:
    found = {origin.sha256: hand for hand, origin in _measured(plan) if origin.file}
    if not found:
        return {}
    if hasattr(plan, "scenes") or len(found) > 1:
        return {f"hand_{i}_sha256": digest for i, digest in enumerate(sorted(found), start=1)}
    (digest, hand), *_ = found.items()
    if hand.by_person:
        return {"population_sha256": digest}
    by_grip = {grip: list(one[:3]) for grip, one in hand.by_grip}
    numbers = {"inertia": hand.inertia, "damping": hand.damping, "stiffness": hand.stiffness}
    return {"hand_sha256": digest, "hand": json.dumps({**numbers, **({"by_grip": by_grip} if by_grip else {})})}


def hand_notes(plan: Any) -> tuple[str, ...]:
    """Messages, each once."""
    return tuple(dict.fromkeys(text for _, origin in _measured(plan) for text in origin.notes))


def preset_inputs(plan: Any) -> dict[str, str]:
    """Name and digest of the preset that the scene of a plan is from; none where it is from none."""
    preset = getattr(plan, "preset", None)
    return {"preset": preset.name, "preset_sha256": preset.sha256} if preset else {}


def preset_files(plan: Any) -> tuple[Path, ...]:
    """The file of that preset."""
    preset = getattr(plan, "preset", None)
    return (preset.file,) if preset else ()


Tables = tuple[Any, ...]  # of pa.Table, or results.parted.Parted


def counted(count: int, what: str, many: str = "") -> str:
    """A number of things, as ``1 cell`` or ``2 cells``; ``many`` is another plural than with s."""
    return f"{count} {what if count == 1 else many or what + 's'}"


class Work:
    """What differs between stages. This is the base: a stage that has nothing but tables."""

    def verify(self, job: Job) -> None:
        """Look for what only the stage can tell is wrong with a plan. Raises `UsageError`."""

    def size(self, plan: Any) -> str:
        """How much there is to do, in a few words: here the cells of a grid."""
        from hknob_cli.specs.cells import cells_of

        return counted(len(cells_of(plan)), "cell")

    def files(self, job: Job) -> tuple[str, ...]:
        """Names of the result files, one a table."""
        raise NotImplementedError

    def texts(self, _job: Job) -> tuple[str, ...]:
        """Names of the pages and drawings that belong to the results."""
        return ()

    def pictures(self, _job: Job) -> tuple[str, ...]:
        """Names of the pictures that `draw` may draw."""
        return ()

    def stale_outputs(self, _job: Job) -> tuple[str, ...]:
        """Names of files that this stage writes for other specs, and that would be stale beside these results."""
        return ()

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """Files, and folders of results, that the result depends on beside the spec."""
        return (*provenance.tables_of(job.plan.values), *preset_files(job.plan))

    def surroundings(self) -> dict[str, str]:
        """What of this machine the result depends on beside `versions`, by name."""
        return {}

    def inputs(self, _job: Job) -> dict[str, str]:
        """Digests of what the result depends on beside the spec, by name. Raises `UsageError`."""
        return {}

    def versions(self, job: Job) -> dict[str, str]:
        """Versions that the result depends on."""
        return grid_versions(getattr(job.plan, "points", None))

    def refuse(self, job: Job) -> None:
        """Raise `RefusedError` where what is there must not be replaced by this job."""

    def compute(self, job: Job) -> Tables:
        """Result tables. Raises `ComputationError`."""
        raise NotImplementedError

    def partial_results(self, _job: Job) -> list[Path]:
        """What is there of that which is needed only until the results are in place."""
        return []

    def is_alone(self, _job: Job) -> bool:
        """Whether nothing else may run beside it: what it measures or drives depends on the clock."""
        return False

    def finished(self, _job: Job) -> str:
        """What an earlier run that was cut short has finished, from which the next goes on; empty if there is none."""
        return ""

    def clear_partial(self, job: Job) -> None:
        """Clear it away."""

    def folders(self, _job: Job) -> tuple[str, ...]:
        """Names of folders in which `compose` writes more than `texts`."""
        return ()

    def is_whole(self, _job: Job, _mark: str) -> bool:
        """Whether all is there that `compose` writes beside `texts`; those have this mark."""
        return True

    def compose(self, _job: Job, _tables: Tables, _stamp: bytes) -> dict[str, str]:
        """The texts by name; ``_stamp`` is the provenance of the results."""
        return {}

    def draw(self, _job: Job, _tables: Tables, _paths: list[Path]) -> list[Path]:
        """Draw the pictures; those drawn, and a message where these results have none."""
        return []

    def then(self, job: Job) -> str:
        """Kind of spec that a user would write after it."""
        return STAGES[job.kind].then

    def take_along(self, _job: Job, _summary: dict[str, Any]) -> tuple[str, str] | None:
        """Kind of spec that takes the best remedy that was found along, and that; None if none does."""
        return None

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Summary as plain data."""
        raise NotImplementedError

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """Summary as the table on the terminal."""
        raise NotImplementedError


class PerceivingWork(Work):
    """Work that depends on the published thresholds, where levels above them are asked for."""

    def inputs(self, job: Job) -> dict[str, str]:
        """Digest of the thresholds by name."""
        if job.plan.perceive is None:
            return {}
        from hknob_cli.perception.level import data_digest

        return {"perception_sha256": data_digest()}

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """The files of those thresholds, too."""
        if job.plan.perceive is None:
            return super().input_files(job)
        from hknob_cli.perception.level import data_files

        return (*super().input_files(job), *data_files())


def note(job: Job, text: str) -> None:
    """A message, unless they are unwanted."""
    if not job.quiet:
        say(text)


def compare_scenes(job: Job) -> None:
    """Say what a sweep that a job is compared with has different. Raises `UsageError`."""
    from hknob_cli.stages.compare import scene_differences

    if found := scene_differences(job.plan.against, job.plan.scene, job.plan.axes):
        note(job, f"{job.plan.name}: the sweep in {job.plan.against} is of another scene: {'; '.join(found)}")


def overlap_of(job: Job) -> dict[str, Any]:
    """How many cells of a job the sweep has that it is compared with, for its summary. Raises `UsageError`."""
    if not job.plan.against:
        return {}
    from hknob_cli.specs.cells import cells_of
    from hknob_cli.stages.compare import overlap

    return {"overlap": overlap(job.plan.against, job.plan.axes, cells_of(job.plan))}
