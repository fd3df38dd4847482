"""What the states of a set have in common: commands under way and, under a controller's law, what it remembers.

All states of a set had the same readings so far, and so the program that commands them is in one state. A law and its
memory are what they are in double precision: they have no error. Each function takes the law first, None without one,
and then `general.controller` commands. Memory is one array, the commands under way or `laws.law.Law`'s ``past``.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NOT_CAPTURED, PROVEN
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.controller import command, read, read_after
from hknob_cli.engine.general.ensemble import enter
from hknob_cli.engine.general.follow import follow_trial
from hknob_cli.engine.general.inner_region import ROUNDINGS
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.laws.cascade import faded, pushed_apart, same_count, sums_agree, torques_apart
from hknob_cli.engine.general.laws.follow import follow_with_law
from hknob_cli.engine.general.laws.period import certify_with_law
from hknob_cli.engine.general.laws.rest import settled_torque
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past, decide
from hknob_cli.engine.general.laws.trials import enter_with_law
from hknob_cli.engine.general.sets.readings import acting, highest, lowest, remembered
from hknob_cli.engine.general.standstill import find_balance, rest_rounding, settles, steady
from hknob_cli.engine.rest import AT_REST, MOVING


def step_error(z, u, older, drift, body):
    """Bound on what roundings add to the error of a state in one interval, under commands up to ``u`` and ``older``."""
    total = drift.once[0] + drift.once[1] * max(abs(u), abs(older))
    for j in range(body.order):
        total += drift.once[2 + j] * abs(z[j])
    return total


def watched(law, wall):
    """The controller by whose edges sets are cut: under a law, that which tells the readings apart that it does."""
    if law is None:
        return wall
    return law.watch


def first_look(law):
    """Where in what is remembered the readings of these looks are."""
    if law is None:
        return 0
    return law.rows + 1


def begin_memory(law, level, ring):
    """Leave in ``ring`` what is remembered before a first sample that acts as ``level``: no command is under way."""
    if law is None:
        for j in range(len(ring)):
            ring[j] = 0.0
        return
    begin_past(ring, level, law)


def begin_at(law, level, ring, wall):
    """Leave in ``ring`` what is remembered at a first sample that acts as ``level``, and the last reading then."""
    if law is None:
        return remembered(level, wall)
    begin_past(ring, level, law)
    return 0.0


def command_all(law, level, before, ring, wall, torques):
    """Command at a sample that acts as ``level``: ``(head, largest)``, of ``ring`` after it, and of the torques.

    ``ring`` has its oldest entry first and is renewed. ``torques`` takes those of the interval: the older command and
    the newer; under a law at the places that `Law.sched` has.
    """
    if law is None:
        u = command(level, before, wall)
        torques[0], torques[1] = u, u
        head = 0 * len(ring)
        if len(ring) > 0:
            torques[0], ring[0] = ring[0], u
            head = 1 % len(ring)
            torques[1] = ring[head]
        return head, max(abs(torques[0]), abs(torques[1]))
    decide(level, 0.0, ring, wall, law)
    largest = 0.0
    for j in range(law.line, len(ring)):
        torques[j] = ring[j]
        largest = max(largest, abs(ring[j]))
    return 0 * len(ring), largest


def advance_memory(law, z, before, ring, head, body, wall, pad):
    """One interval of a single motion, by its own readings: ``(reading, head)``."""
    if law is None:
        return advance(z, before, ring, head, body, wall, pad)
    advance_with_law(z, ring, body, wall, law, pad)
    return 0.0, head


def store_memory(law, ring, head, points, at):
    """Enter what is remembered to ``points[at:]``; readings that no law tells from others as what stands for them."""
    delay = len(ring)
    for j in range(delay):
        points[at + j] = ring[(head + j) % delay]
    if law is None:
        return
    if law.watch.damping == 0.0:
        for j in range(law.rows, law.line):
            points[at + j] = min(points[at + j], 0.0)


def reading_of(law, z, before, ring, wall):
    """What the encoder shows at the sample of a motion; with hysteresis after the count of its last turning point."""
    if law is None:
        return read_after(z[0], before, wall)
    return read_after(z[0], ring[law.line - 1], wall)


class OrbitSample(NamedTuple):
    """A sample of a proven orbit.

    ``points``: row, last reading, state and memory, from ``base`` on, as `known.add_points` leaves them; ``room``: of
    its row, as `captured_with_law` has it.
    """

    points: Any
    base: int
    room: float


def memory_apart(law, before, ring, head, sample, body, wall):
    """Bound on how far a motion is pushed from an orbit's by what it remembers; infinite where that is not the same."""
    points, room = sample.points, sample.room
    delay, at = len(ring), sample.base + 2 + body.order
    if law is None:
        if (wall.damping > 0.0 or wall.hysteresis > 0.0) and before != points[sample.base + 1]:
            return float("inf")
        for j in range(delay):
            if ring[(head + j) % delay] != points[at + j]:
                return float("inf")
        return 0.0
    for j in range(delay):
        law.beside[j] = points[at + j]
    if not same_count(ring, law.beside, law) or not sums_agree(ring, law.beside, room, law):
        return float("inf")
    if law.guarded and not faded(ring, law.beside, law) < room:
        return float("inf")
    return pushed_apart(torques_apart(ring, law.beside, law), points[sample.base + 2], body)


def counted_alike(law, ring, points, at):
    """Whether all that a law counts, readings apart, is the same in ``ring`` and from ``points[at:]`` on."""
    if law is None:
        return True
    for j in range(len(ring)):
        law.beside[j] = points[at + j] if j < law.rows else ring[j]
    return same_count(ring, law.beside, law)


def certify_again(law, period, known, body, wall):
    """Prove the orbit through ``known.z`` with what ``known.ring`` remembers: ``(status, margin, bound, room)``.

    Both are moved to the orbit. Without a law that proof was the first, and is not done again.
    """
    if law is None:
        return DIFFERENT, 0.0, 0.0, 0.0
    status, margin, _, _, bound = certify_with_law(known.z, known.ring, period, body, wall, law, known.space)
    if status == PROVEN or status == NOT_CAPTURED:
        copy_to(known.z, known.space.orbit)
        copy_to(known.ring, law.periodic)
        return PROVEN, margin, bound, law.room[0]
    return DIFFERENT, 0.0, 0.0, 0.0


def rest_within(law, z, level, before, ring, body, wall, space):
    """Where a motion without friction that acts as ``level`` comes to rest: ``(fate, shown, gap, push, bound)``.

    ``shown``: the reading there; ``gap``: how far it is from a change of torque; ``push``: by how much torques that
    still change may carry the motion away; ``bound``: on all roundings, in counts. The rest is left in ``space.orbit``,
    and how far ``z`` is from it in ``space.away``.
    """
    orbit, away = space.orbit, space.away
    if law is None:
        shown = read_after(z[0], before, wall)
        fate, gap = settles(z, shown, before, ring, body, wall, orbit, away)
        if fate != AT_REST:
            return fate, shown, gap, 0.0, 0.0
        return fate, shown, gap, 0.0, rest_rounding(z, orbit[0], command(shown, shown, wall), body)
    still, last = settled_torque(z[0], level, ring, wall, law)
    if not still or not find_balance(last.u, body, orbit):
        return MOVING, level, 0.0, 0.0, 0.0
    for j in range(body.order):
        away[j] = z[j] - orbit[j]
    gap = min(orbit[0] - lowest(level, -float("inf"), law.watch), highest(level, law.watch) - orbit[0])
    gap += 0.5 * wall.hysteresis
    # Under a torque that is off by so much the knob swings about another rest, and comes as far beyond that.
    bound = rest_rounding(z, orbit[0], abs(last.u) + 2.0 * last.wrong / (ROUNDINGS * EPSILON), body)
    return AT_REST, read(orbit[0], wall), gap, pushed_apart(last.left, z[0], body), bound


def settle_memory(law, x, level, before, ring, wall):
    """Whether the torque comes to an end if ``level`` goes on for ever: ``(whether, torque, wrong, left)``.

    ``wrong``: bound on its rounding; ``left``: on what it still differs by, summed over all samples to come. ``x``:
    about where the knob is.
    """
    if law is None:
        u = command(level, level, wall)
        return steady(ring, u) and not (wall.damping > 0.0 and before != level), u, 0.0, 0.0
    still, last = settled_torque(x, level, ring, wall, law)
    return still, last.u, last.wrong, last.left


def keeps_torque(law, x, level, u, wall):
    """Whether the torque ``u``, to which that of ``level`` comes in the end, is that of the reading at ``x``, too."""
    if law is None:
        shown = read(x, wall)
        return command(shown, shown, wall) == u
    return acting(x, -float("inf"), law.watch) == level


def copy_settled(law, ring, out):
    """Leave in ``out`` what is remembered in the end, after `settle_memory`."""
    for j in range(len(ring)):
        out[j] = ring[j]
    if law is None:
        return
    for j in range(len(ring)):
        out[j] = law.periodic[j]


def find_end(law, before, budget, limit, known, body, wall):
    """What the motion from ``known.z`` and ``known.ring`` ends in: ``(fate, period, before, head, samples)``."""
    last = TrialBudget(0, budget, True, limit)
    if law is None:
        return follow_trial(known, before, 0 * len(known.ring), last, body, wall)
    fate, period, used = follow_with_law(known, last, body, wall, law)
    return fate, period, before, 0 * len(known.ring), used


def enter_end(law, fate, period, before, head, known, body, wall):
    """Row of an end whose state is in ``known.z`` and ``known.ring``, as `ensemble.enter`."""
    if law is None:
        return enter(fate, period, before, head, known, body, wall)
    return enter_with_law(fate, period, known, body, wall, law)
