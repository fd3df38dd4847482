"""The command line with pieces and parts so small that a sweep of seconds is spread like one of hours.

`python small_pieces.py [CODE] ARGS...` is `hknob ARGS...`; CODE, if it is not empty, is run before, to bring a fault.
"""

import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

# Code after which all cells fit into one file.
ONE_FILE = "from hknob_cli.results import parted; parted.Parting.__new__.__defaults__ = (99,)"

PART, MOST = 4, 1  # cells in a part, and in a piece; with two, a piece were a part


def shrink(part: int = PART, most: int = MOST) -> None:
    """Make pieces and parts small; before anything of the program is loaded."""
    from hknob_cli.results import parted

    parted.PART_CELLS = part
    parted.Parting.__new__.__defaults__ = (part,)
    from hknob_cli.spread import gather
    from hknob_cli.stages.sweep import run as sweep

    gather.MOST = most
    gather.Pace.__init__.__kwdefaults__.update(first=most, most=most)
    sweep.SPREAD_ABOVE = 0


if __name__ == "__main__":
    signals = {signal.SIGINT, signal.SIGTERM}
    signal.pthread_sigmask(signal.SIG_BLOCK, signals)  # until the program has begun to heed them
    from hknob_cli.cli import handover, main

    shrink()
    code = sys.argv.pop(1)
    exec(code)
    if not handover.pays(sys.argv[1:]):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)
    main.main()
