"""Tests of `spread.cluster` that need no cluster; the others are in `tests/faults/test_dask_faults.py`."""

import subprocess
import sys

UNASKED = """
import asyncio, gc
from hknob_cli.spread import cluster
{hush}
loop = asyncio.new_event_loop()
asyncio.run_coroutine_threadsafe(cluster._awaited(None), loop)
del loop
gc.collect()
"""


def said(hush: str) -> str:
    """What a process prints whose loop ends with a question that it has not asked yet."""
    asked = subprocess.run([sys.executable, "-c", UNASKED.format(hush=hush)], capture_output=True, text=True, timeout=60)
    return asked.stderr


def test_a_question_left_unasked_by_an_interruption_says_nothing() -> None:
    assert said("cluster._hush()") == ""
    assert "never awaited" in said("")
