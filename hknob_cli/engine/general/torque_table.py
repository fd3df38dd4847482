"""Torque over the measured angle: a command for every count, from a flat table.

The table has `HEAD` numbers; then, for each of its counts, the command; then the lowest, and then the highest count of
the run that this count is in. A run is a row of counts with one command: inside it a motion crosses count edges and
nothing changes. Beyond its ends the table repeats itself every turn, each time with a constant added: 0 for detents all
the way round, what a spring adds for end stops. Two motions with the same counts, or in the same runs, get the same
commands. Units are those of `engine.loop`.

The compiler makes code of its own for scenes without any part of this kind, in which nothing of this is left: a table
that is None is known by its type. Beside other such parts it is empty (`search.as_compiled`).
"""

from hknob_cli.engine.loop import floor

FIRST, TURN, RISE_BELOW, RISE_ABOVE = 0, 1, 2, 3  # first count; counts of a turn; what a turn up adds, below and above
HEAD = 4


def is_there(table):
    """Whether there is a table."""
    if table is None:
        return False
    return bool(len(table))


def locate(shown, table):
    """Place of a count in the table, and how many turns above that place it is."""
    size = (len(table) - HEAD) // 3
    place, turns = shown - table[FIRST], 0.0
    if place < 0.0:
        turns = floor(place / table[TURN])
    elif place >= size:
        turns = floor((place - size) / table[TURN]) + 1.0
    place -= turns * table[TURN]
    # Positions that no double tells apart any more may come out beyond the ends.
    return int(min(max(place, 0.0), size - 1.0)), turns


def command_at(shown, table):
    """Command at a count; 0 without a table."""
    if table is None or not len(table):
        return 0.0
    place, turns = locate(shown, table)
    return table[HEAD + place] + turns * (table[RISE_BELOW] if turns < 0.0 else table[RISE_ABOVE])


def run_at(shown, table):
    """Lowest and highest count of the run that a count is in; infinite where it does not end, or without a table."""
    if table is None or not len(table):
        return -float("inf"), float("inf")
    place, turns = locate(shown, table)
    size = (len(table) - HEAD) // 3
    low, high = table[HEAD + size + place], table[HEAD + 2 * size + place]
    shift = turns * table[TURN]
    if low == -float("inf") or high == float("inf"):
        return low, high  # one run, however many turns are between: its other end stays where it is
    return low + shift, high + shift
