"""Loads the command with small pieces and parts (`small_pieces`), and serves forks of it (`tests.forked`)."""

import socket
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

if __name__ == "__main__":
    from tests.faults.small_pieces import shrink
    from tests.forked import load, serve

    shrink()  # before anything of the program is loaded
    load()
    serve(socket.socket(fileno=int(sys.argv[1])))
