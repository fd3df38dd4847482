"""A port: opened by its name or URL, and the thread between a session and it.

Opening a port by its name or URL, with one clear line for each way it can fail.
"""

import errno
import threading
import time
from typing import Any

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.wire.session import Session
from hknob_cli.specs.campaign import url_fault

# A read returns after this time with all that came, whatever kind of port it is: few system calls, ALIVE in time.
READ_S = 0.0025
MOST_READ_BYTES = 65536
# A longer pause than this was this computer's (stopped, or too busy): time spent not listening is not silence.
LONGEST_STEP_S = 0.05

WRITE_S = 0.02


class Pump:
    """Runs a session over an open pyserial port; ``changed`` guards the session, and tells when something came."""

    def __init__(self, port: Any, session: Session) -> None:
        self.changed = threading.Condition()
        self.broken: str | None = None
        self._port = port
        self._session = session
        self._ending = threading.Event()
        # A daemon: if the program ends without closing, ALIVE ends with it, and the watchdog acts.
        self._thread = threading.Thread(target=self._run, name="hknob wire", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def end(self) -> None:
        """End, and wait until the thread has."""
        self._ending.set()
        self._thread.join()

    def _run(self) -> None:
        import serial

        attended, before = 0.0, time.monotonic()
        try:
            self._write(b"\0")  # ends whatever the target was sent before
            while not self._ending.is_set():
                data = self._port.read(MOST_READ_BYTES)
                now = time.monotonic()
                attended, before = attended + min(now - before, LONGEST_STEP_S), now
                with self.changed:
                    self._session.feed(data, now=attended, arrived_s=now)
                    due = self._session.due(attended)
                    self.changed.notify_all()
                self._write(due)
            # A RELEASE asked for just before the end still goes out.
            self._write(self._session.due(attended))
        except (serial.SerialException, OSError, TypeError) as error:
            # TypeError: pyserial's, when the port is closed under its feet.
            with self.changed:
                self.broken = str(error)
                self.changed.notify_all()

    def _write(self, data: bytes) -> None:
        import serial

        if data:
            try:
                self._port.write(data)
            except serial.SerialTimeoutException:
                return  # nobody takes the bytes: commands are sent again, and silence is noticed


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
