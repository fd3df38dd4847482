"""Loaded by a worker of a cluster: pieces take a while, so that it can be killed while it is at one."""

import os
import signal
import time

from hknob_cli.stages.sweep import assembly

SECONDS = 0.1
DEADLY = int(os.environ.get("HKNOB_TEST_DEADLY", -1))  # a cell that kills its worker


def slow(plain=assembly.find_piece):
    """`find_piece`, taking its time."""

    def find_piece(stage, start, stop):
        time.sleep(SECONDS)
        if start <= DEADLY < stop:
            os.kill(os.getpid(), signal.SIGKILL)
        return plain(stage, start, stop)

    return find_piece


if assembly.find_piece.__module__ == assembly.__name__:  # a worker loads this more than once
    assembly.find_piece = slow()
