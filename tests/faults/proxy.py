"""A line between two ports on this machine that can be frozen, as a cable that is pulled, or cut."""

import selectors
import socket
import threading
from contextlib import suppress

from tests.faults.dask_cluster import free_port

PATIENCE_S = 10.0


class Proxy:
    """Carries connections to ``target`` on, until told otherwise."""

    def __init__(self, target: int) -> None:
        self.target = target
        self.port = free_port()
        self.frozen = threading.Event()
        self.closed = threading.Event()
        self._others: dict[socket.socket, socket.socket] = {}
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._carry, daemon=True)

    def __enter__(self) -> "Proxy":
        self._server = socket.create_server(("127.0.0.1", self.port))
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._server, selectors.EVENT_READ)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.closed.set()
        self._thread.join()
        self.cut()
        self._server.close()
        self._selector.close()

    def cut(self) -> None:
        """Close all connections, once the carrier has passed on what it holds."""
        with self._lock:
            for one in self._others:
                self._selector.unregister(one)
                one.close()
            self._others.clear()

    def _carry(self) -> None:
        while not self.closed.is_set():
            for key, _ in self._selector.select(0.05):
                if self.frozen.is_set():
                    self.closed.wait(0.05)
                    break
                one = key.fileobj
                assert isinstance(one, socket.socket)
                with self._lock:
                    if one is self._server:
                        self._join()
                    elif one in self._others:  # it may have been cut since it was selected
                        self._pass_on(one)

    def _join(self) -> None:
        near, _ = self._server.accept()
        try:
            far = socket.create_connection(("127.0.0.1", self.target))
        except OSError:
            near.close()
            return
        self._others |= {near: far, far: near}
        for one in (near, far):
            one.settimeout(PATIENCE_S)  # an end that reads nothing is as good as gone: no test waits for it for ever
            self._selector.register(one, selectors.EVENT_READ)

    def _pass_on(self, one: socket.socket) -> None:
        with suppress(OSError):
            if data := one.recv(1 << 16):
                self._others[one].sendall(data)
                return
        for end in (one, self._others.pop(one)):
            self._others.pop(end, None)
            self._selector.unregister(end)
            end.close()
