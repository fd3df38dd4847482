"""The published thresholds as files that a stage's results depend on, where levels above them are asked for."""

from pathlib import Path

from hknob_cli.specs.perception import Perceive


def threshold_inputs(how: Perceive | None) -> dict[str, str]:
    """Their digest by name; none where no levels are asked for."""
    if how is None:
        return {}
    from hknob_cli.perception.published import data_digest

    return {"perception_sha256": data_digest()}


def threshold_files(how: Perceive | None) -> tuple[Path, ...]:
    """The files; none where no levels are asked for."""
    if how is None:
        return ()
    from hknob_cli.perception.published import data_files

    return data_files()
