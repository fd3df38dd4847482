"""Opening a port by its name or URL, with one clear line for each way it can fail."""

import errno
from typing import Any

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.wire.pump import READ_S
from hknob_cli.specs.campaign import url_fault

WRITE_S = 0.02


def open_port(url: str, *, baud: int) -> Any:
    """A port in raw mode, for this process alone, with nothing stale in it. Raises DeviceError."""
    import serial

    if wrong := url_fault(url):
        raise DeviceError(f"{url}: {wrong}")
    try:
        port = serial.serial_for_url(url, baudrate=baud, timeout=READ_S, write_timeout=WRITE_S, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        raise DeviceError(f"{url}: {_reason(error)}") from error
    try:
        port.reset_input_buffer()
    except (serial.SerialException, OSError) as error:
        port.close()
        raise DeviceError(f"{url}: it was opened, but cannot be read: {error}") from error
    return port


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    text = str(error)
    if number == errno.ENOENT or "FileNotFoundError" in text:
        return f"there is no such port; {_seen()}"
    if number == errno.EACCES or "PermissionError" in text:
        return "no permission to open this port (on Linux, join the group that owns it, often dialout), or it is in use"
    if number in (errno.EAGAIN, errno.EBUSY):
        return "this port is in use by another program; close that first"
    if isinstance(error, ValueError):
        return f"this is not a port, nor a URL that pyserial knows: {text}"
    if "Could not configure port" in text:
        return f"this is not a serial port: {text}"
    return f"this port cannot be opened: {text}"


def _seen() -> str:
    from serial.tools.list_ports import comports

    ports = sorted(each.device for each in comports())
    return f"this computer has {', '.join(ports)}" if ports else "this computer has no serial ports"
