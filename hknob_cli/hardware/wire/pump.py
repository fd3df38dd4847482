"""The thread between a session and its port: takes what comes, sends what is due, every few milliseconds."""

import threading
import time
from typing import Any

from hknob_cli.hardware.wire.session import Session

# A read returns after this time with all that came, whatever kind of port it is: few system calls, ALIVE in time.
READ_S = 0.0025
MOST_READ_BYTES = 65536
# A longer pause than this was this computer's (stopped, or too busy): time spent not listening is not silence.
LONGEST_STEP_S = 0.05


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
