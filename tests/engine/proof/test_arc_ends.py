"""All clock phases of one start end where trials at 60 digits do, from phases beside the ends of every arc."""

from itertools import pairwise

import mpmath as mp
import pytest

from hknob_cli.engine.loop import Loop, interval, level_of, make_loop, push
from hknob_cli.engine.sets import arc
from hknob_cli.engine.sets.room import make_arc_room
from tests.engine.sets.loops import follow_all, known, zeros

from .orbits import DIGITS, drive, plant

SAMPLES = 200  # of a trial, the last half of which is looked at
CELLS = [
    (4.37, 0, make_loop(0.187, 0.211, 0.556, 0.6, 1.0, 0.0, 0.0)),
    (10.2, 0, make_loop(0.582, 0.0828, 0.536, 0.3, -1.0, 0.0, 0.0)),
    (2.78, 1, make_loop(0.436, 0.1064, 0.834, 0.6, 1.0, 0.0, 0.4)),
    (7.78, 1, make_loop(0.562, 0.0754, 0.779, 1.2, -1.0, 0.0, 0.4)),
]


def turned(levels: list[float]) -> tuple[float, ...]:
    """One period, turned so that every way to write it is the same."""
    return min(tuple(levels[i:] + levels[:i]) for i in range(len(levels)))


def levels_of(phase: float, start: float, delay: int, loop: Loop) -> list[float]:
    """Levels of a trial at 60 digits, let go at rest so long before its first sample."""
    with mp.workdps(DIGITS):
        whole, parts = plant(loop, phase), [plant(loop, t) for t in (loop.split, 1.0 - loop.split) if t > 0.0]
        p, s, g, _ = whole
        x, v = p * start + g * drive(0.0, loop), -mp.mpf(loop.beta) * s * start + s * drive(0.0, loop)
        acting, found = [0.0] * (delay + 1), []
        for _ in range(SAMPLES):
            level = float(mp.floor(x) if loop.sense > 0.0 else mp.ceil(x))
            found.append(min(level, 0.0))
            acting = [*acting, found[-1]][-delay - 1 :] if delay else [found[-1]]
            drives = [drive(one, loop) for one in acting][-len(parts) :]
            for (p, s, g, f), push_on in zip(parts, drives, strict=True):
                x, v = p * x + s * v + g * push_on, -mp.mpf(loop.beta) * s * x + f * v + s * push_on
        return found


@pytest.mark.parametrize(("start", "delay", "loop"), CELLS)
def test_every_arc_ends_where_its_trials_do(start: float, delay: int, loop: Loop) -> None:
    """Both its ends, except for a billionth, and its middle; arcs leave no gap, and shares are their lengths."""
    ends, room = known(delay), make_arc_room(zeros, delay)
    samples, arcs, undecided, shortest, covered, whole = follow_all(
        start, 0.0, delay, 20_000, 100, 1e6, room, ends, loop
    )
    rows = int(ends.counts[0])
    assert whole
    assert rows > 1
    assert undecided == room.progress[arc.SPENT] == 0.0
    assert samples < 3000  # found by what captures them, not by waiting
    expected = []
    for row in range(rows):
        n, x, v = int(ends.table[10 * row + 1]), ends.table[10 * row + 2], ends.table[10 * row + 3]
        line, at, levels = list(ends.lines[row * delay : (row + 1) * delay]), 0, []
        for _ in range(n):
            levels.append(level_of(x, loop.sense))
            x, v = interval(x, v, *push(levels[-1], line, at, loop), loop)
            at = (at + 1) % delay if delay else 0
        expected.append(turned(levels))
    found = sorted(tuple(room.ended[3 * k : 3 * k + 3]) for k in range(arcs))
    assert (found[0][0], max(high for _, high, _ in found)) == (0.0, 1.0)
    assert all(after[0] <= one[1] for one, after in pairwise(found))
    assert shortest == min(high - low for low, high, _ in found)
    assert covered == pytest.approx(sum(high - low for low, high, _ in found), abs=1e-14)
    assert 0.0 <= covered - 1.0 < 1e-8
    for row in range(rows):
        share = sum(high - low for low, high, of in found if of == row)
        assert ends.table[10 * row + 8] == pytest.approx(share, abs=1e-14)
        assert share > 0.0
    for low, high, row in found:
        inside = 1e-9 * (high - low) + (covered - 1.0)
        for phase in (low + inside, 0.5 * (low + high), high - inside):
            last, n = levels_of(phase, start, delay, loop)[SAMPLES // 2 :], len(expected[int(row)])
            assert last[n:] == last[:-n]
            assert turned(last[:n]) == expected[int(row)]
