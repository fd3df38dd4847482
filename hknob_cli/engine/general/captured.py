"""Where a trial comes that has been there before: to a proven orbit, which captures it, or to where it was itself."""

from hknob_cli.engine.follow import CYCLE_PROVEN
from hknob_cli.engine.general.cogging import far_around, gap_apart
from hknob_cli.engine.general.controller import depth_level, inside
from hknob_cli.engine.general.torque_curve import has_curve, place_at

FIELDS = 10  # of an attractor: fate, period, margin, edge, closure, bound, trials, least, most position, reading before
LOOK_AGAIN = 64  # samples after which a motion that may stand still is compared
CLOSE = 1e-12  # of a position: so close it has come to a standstill


def may_be_captured(x, trial, body):
    """Whether a position is within the margin of the deepest sample of a proven orbit."""
    for row in range(int(trial.counts[0])):
        base = row * FIELDS
        if abs(x - trial.states[row * body.order]) < trial.table[base + 2] and trial.table[base] == CYCLE_PROVEN:
            return True
    return False


def captured(trial, before, head, body, wall):
    """Row of the proven orbit so close, at its deepest sample, to a trial that it is followed for ever; -1 if none."""
    z, ring, away = trial.z, trial.ring, trial.space.away
    table, states, lines = trial.table, trial.states, trial.lines
    n, delay = body.order, len(ring)
    for row in range(int(trial.counts[0])):
        base = row * FIELDS
        margin = table[base + 2] - table[base + 5]
        if table[base] != CYCLE_PROVEN or abs(z[0] - states[row * n]) >= margin:
            continue
        if wall.damping > 0.0 and before != table[base + 9]:
            continue
        if wall.hysteresis > 0.0 and inside(before, wall) != inside(table[base + 9], wall):
            continue
        same = True
        for j in range(delay):
            same = same and ring[(head + j) % delay] == lines[row * delay + j]
        for j in range(n):
            away[j] = z[j] - states[row * n + j]
        if same and far_around(body.cogs, away, states[row * n], body) < margin:
            return row
    return -1


def has_period(period, rows, table):
    """Whether a proven orbit has a period that divides ``period``."""
    for row in range(rows):
        if table[row * FIELDS] == CYCLE_PROVEN and period % int(table[row * FIELDS + 1]) == 0:
            return True
    return False


def turn_level(shown, last, level):
    """Level that falls where a motion has turned down: beside a curve an event that no cycle lacks."""
    if shown == last:
        return level
    return 1.0 if shown > last else 0.0


def first_level(shown, wall):
    """The level before a trial's first sample, which shows ``shown``."""
    return 0.0 if has_curve(wall.curve) else depth_level(shown, wall)


def changes_level(shown, last, level, wall):
    """The level of a sample that shows ``shown``, after ``last`` and ``level``: ``(level, whether it acts alike)``."""
    now = depth_level(shown, wall)
    same = now == level if wall.analog == 0.0 else (shown < 0.0) == (last < 0.0)
    if has_curve(wall.curve):
        now = turn_level(shown, last, level)
        same = same and place_at(shown, wall.curve) == place_at(last, wall.curve)
    return now, same


def came_back(trial, head, chead, body):
    """Whether a motion is where it was at the checkpoint, with the commands under way."""
    z, ring, away = trial.z, trial.ring, trial.space.away
    delay = len(ring)
    for j in range(body.order):
        away[j] = z[j] - trial.check[j]
    for j in range(delay):
        u = ring[(head + j) % delay]
        if not abs(u - trial.check_ring[(chead + j) % delay]) <= CLOSE * (1.0 + abs(u)):
            return False
    return gap_apart(body.cogs, away, body) <= CLOSE * (1.0 + abs(z[0]))
