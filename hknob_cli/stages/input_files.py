"""Files that results depend on beside the spec: those that hands are from, and the published thresholds."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hknob_cli.specs.parts import Origin
from hknob_cli.specs.plan import Hand
from hknob_cli.stages.job import Job
from hknob_cli.stages.work import Work


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


class PerceivingWork(Work):
    """Work that depends on the published thresholds, where levels above them are asked for."""

    def inputs(self, job: Job) -> dict[str, str]:
        """Digest of the thresholds by name."""
        if job.plan.perceive is None:
            return {}
        from hknob_cli.perception.published import data_digest

        return {"perception_sha256": data_digest()}

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """The files of those thresholds, too."""
        if job.plan.perceive is None:
            return super().input_files(job)
        from hknob_cli.perception.published import data_files

        return (*super().input_files(job), *data_files())
