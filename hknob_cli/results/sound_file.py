"""A clip of a motion as a WAV file."""

from pathlib import Path

from hknob_cli.errors import unwritable
from hknob_cli.perception.sound import Clip, wav_bytes
from hknob_cli.results.files import create, put_in_place


def write_wav(sound: Clip, path: Path) -> None:
    """Write a clip, whole or not at all, and for good. Raises `ComputationError` if the file cannot be written."""
    half = path.with_name(path.name + ".part")
    try:
        try:
            with create(half) as stream:
                stream.write(wav_bytes(sound))
            put_in_place(half, path)
        finally:
            half.unlink(missing_ok=True)
    except OSError as error:
        raise unwritable(path, error) from None
