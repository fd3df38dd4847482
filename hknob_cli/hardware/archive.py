"""The folder of a campaign under way: finished trials, the journal of the one at hand, and those that were broken off.

Recordings of a real device are sources: they are never deleted, and a campaign that was begun with another spec is not
gone on with. What was computed can be computed again, and is cleared away when it is of another spec or program.
"""

import contextlib
import json
import shutil
from pathlib import Path
from typing import Any

from hknob_cli.errors import MISSHAPEN, ComputationError, RefusedError
from hknob_cli.hardware.journal import ABOUT, RECORDING, Journal, Journalled, read_about, read_journal, refuse_other
from hknob_cli.hardware.order import Trial
from hknob_cli.hardware.trial_file import Recorded, joined, read_trial, sample_table, write_trial, zero_of
from hknob_cli.recordings.trial import Key
from hknob_cli.results.files import create, make_folder, put_in_place, refuse_link, sync_folder
from hknob_cli.results.store import partial
from hknob_cli.specs.seal import BLANK, is_changed, sealed

_ABORTED = "aborted"


class Archive:
    """Trials of one campaign on the disk."""

    def __init__(self, out: Path, *, identity: str, is_source: bool, stamp: bytes) -> None:
        """``out``: the results folder; ``identity``: a digest that is another for another campaign."""
        self.folder = out / RECORDING
        self._identity = identity
        self._is_source = is_source
        self._stamp = stamp

    def enter(self) -> None:
        """Go on with what is there, or begin. Raises `RefusedError` if it is another campaign's, of a real device."""
        refuse_link(self.folder)
        self._finish_removing()
        about = self._about()
        if about is not None and about.get("identity") != self._identity:
            refuse_other(self.folder.parent, self._identity)
            self._remove()
            about = None
        try:
            make_folder(self.folder)
            if about is None:
                half = partial(self.folder / ABOUT)
                with create(half) as stream:
                    said = {"seal": BLANK.decode(), "identity": self._identity, "source": self._is_source}
                    stream.write(sealed(json.dumps(said).encode()))
                put_in_place(half, self.folder / ABOUT)
        except OSError as error:
            raise ComputationError(f"{self.folder}: cannot be written: {error.strerror or error}") from None

    def abandon(self) -> None:
        """Remove the folder again, if nothing is in it but what it is of."""
        with contextlib.suppress(OSError):
            if [path.name for path in self.folder.iterdir()] == [ABOUT]:
                (self.folder / ABOUT).unlink()
                self.folder.rmdir()

    def _about(self) -> dict[str, Any] | None:
        """What the folder says it is of; None where nothing is in it. Raises `RefusedError` if it is not ours."""
        about = read_about(self.folder)
        if about is None and self.folder.exists():
            if self.folder.is_dir() and all(path.name.startswith(".") for path in self.folder.iterdir()):
                return None
            if is_changed(self.folder / ABOUT):
                raise RefusedError(
                    f"{self.folder / ABOUT}: is not as it was written: damaged, or changed; put a copy of it back, or "
                    "choose another --out"
                )
            raise RefusedError(f"{self.folder}: not written by hknob; move it away, or choose another --out")
        return about

    def finished(self, trial: Trial) -> Recorded | None:
        """A trial that is done; None if it is not.

        Raises `ComputationError` for a recording of a device that is not as it was written: it cannot be made again;
        `OSError` where its journal cannot be removed.
        """
        path = self._path(trial, "parquet")
        if not path.is_file():
            return None
        found = read_trial(path)
        if found is None and self._is_source:
            raise ComputationError(
                f"{path}: is not as it was recorded: damaged, or changed; put a copy of it back, or move it away to "
                "record this trial anew"
            )
        if found is None or found.trial != trial:
            return None
        self._path(trial, "part").unlink(missing_ok=True)  # a run was cut short as it was to do so
        return found

    def begin(self, trial: Trial, about: dict[str, Any]) -> Journal:
        """The journal of a trial; what there is of it from before is set aside."""
        self._keep_other(trial)
        self.set_aside(trial)
        return Journal(self._path(trial, "part"), {"trial": trial.values, **about})

    def finish(self, recorded: Recorded) -> None:
        """Put a trial in place, whole, and end its journal. Raises `ComputationError` if it cannot be written."""
        write_trial(self._path(recorded.trial, "parquet"), recorded, self._stamp)
        self._path(recorded.trial, "part").unlink(missing_ok=True)

    def set_aside(self, trial: Trial) -> Path | None:
        """Keep what the journal of an unfinished trial has, under ``aborted``; where, None if there is nothing.

        Raises `ComputationError` if it cannot be written; the journal then stays.
        """
        part = self._path(trial, "part")
        if not part.exists():
            return None
        try:
            found = read_journal(part)
            if found is not None and not found.blocks and found.whole:
                part.unlink()
                return None
            recorded = _broken_off(found, trial) if found is not None and found.blocks else None
            kept = self._free(trial)
            make_folder(kept.parent)
            if recorded is not None:
                write_trial(kept.with_suffix(".parquet"), recorded, self._stamp)
            if found is None or not found.whole or recorded is None:
                put_in_place(part, kept.with_suffix(".part"))  # with bytes that nobody could read
            else:
                part.unlink()
        except OSError as error:
            raise ComputationError(f"{part}: cannot be set aside: {error.strerror or error}") from None
        return kept.with_suffix(".part" if recorded is None else ".parquet")

    def _keep_other(self, trial: Trial) -> None:
        """What a device recorded of another trial is kept, if it lies here. Raises `ComputationError`."""
        path = self._path(trial, "parquet")
        try:
            if self._is_source and path.is_file():
                kept = self._free(trial)
                make_folder(kept.parent)
                put_in_place(path, kept.with_suffix(".parquet"))
        except OSError as error:
            raise ComputationError(f"{path}: cannot be set aside: {error.strerror or error}") from None

    def _free(self, trial: Trial) -> Path:
        """A name under ``aborted`` that is not taken, without its ending."""
        number = 1
        while any((self.folder / _ABORTED).glob(f"{trial.label}_{number}.*")):
            number += 1
        return self.folder / _ABORTED / f"{trial.label}_{number}.x"

    def _path(self, trial: Trial, ending: str) -> Path:
        return self.folder / f"{trial.label}.{ending}"

    def scaffold(self) -> list[Path]:
        """What `leave` would clear away, where it is this campaign's."""
        if self._is_source:
            return []
        about = read_about(self.folder)
        ours = about is not None and not about["source"] and about["identity"] == self._identity
        return [path for path, there in ((self.folder, ours), (partial(self.folder), True)) if there and path.exists()]

    def leave(self) -> None:
        """Clear away what can be computed again, once the results are in place."""
        if not self._is_source:
            self._remove()

    def clear(self) -> None:
        """Remove what is there of an earlier campaign; never what holds recordings of a device."""
        about = self._about()
        if about is not None and not about.get("source", True):
            self._remove()

    def _remove(self) -> None:
        """Remove the folder; one that was half removed would not say any more what it is of, so it is renamed first."""
        self._finish_removing()
        try:
            if self.folder.exists():
                self.folder.rename(partial(self.folder))
                sync_folder(self.folder.parent)
        except OSError as error:
            raise ComputationError(f"{self.folder}: cannot be removed: {error.strerror or error}") from None
        self._finish_removing()

    def _finish_removing(self) -> None:
        going = partial(self.folder)
        try:
            if going.exists():
                shutil.rmtree(going)
        except OSError as error:
            raise ComputationError(f"{going}: cannot be removed: {error.strerror or error}") from None


def _broken_off(found: Journalled, trial: Trial) -> Recorded | None:
    """What a journal has of a trial; None where it does not say what it is of, as the program writes it."""
    try:
        samples = joined(found.blocks)
        key, native, device = Key(*found.about["key"]), found.about["native_counts"], found.about["device"]
        recorded = Recorded(
            trial=trial,
            table=sample_table(samples, key, trial, native),
            ended="aborted",
            settled_sample=None,
            gaps=0,
            overruns=samples.overruns,
            zero_n=zero_of(samples),
            device=device,
            native_counts=native,
        )
    except MISSHAPEN:
        return None
    return recorded if recorded.is_sane else None
