"""Following one trial of the general loop until its fate is proven: as `engine.follow`, with friction and the rest."""

from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    FIRST_REST_TEST,
    FIRST_TOLERANCE,
    GREW,
    LEFT,
    REST_EDGE,
    REST_PROVEN,
    UNDAMPED,
    UNSETTLED,
    same_line,
)
from hknob_cli.engine.general.cogging import far_apart, gap_apart, has_cogs, has_gone
from hknob_cli.engine.general.controller import command, depth_level, inside, read, read_after
from hknob_cli.engine.general.inner_region import stands
from hknob_cli.engine.general.interval import advance, advance_jittering
from hknob_cli.engine.general.jitter import jitters
from hknob_cli.engine.general.period_map import AT_EVENT, EXPANDS, PARTS, certify
from hknob_cli.engine.general.slide_two import step_with_friction
from hknob_cli.engine.general.standstill import SETTLING, settles
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, REST_ON_EDGE, RINGS

CYCLE_AT_EVENT = 9
CYCLE_EXPANDS = 10
CYCLE_PARTS = 15
KNOWN = 11  # reaches an orbit that another trial has proven
WAIT = -1  # a candidate left for later
BESIDE = 1e-6  # counts from a cycle through the play of teeth, at which a trial is not followed further
PATIENCE = 12  # times that one is, each at a quarter of the gap
PROOF_COST = 8  # periods that a trial with a continuous sensor goes on for after an attempt that took about as many
FIELDS = 10  # of an attractor: fate, period, margin, edge, closure, bound, trials, least, most position, reading before


def captured(z, before, ring, head, body, wall, away, rows, table, states, lines):
    """Row of the proven orbit, at its deepest sample, so close to ``z`` that it is followed for ever; -1 if none."""
    n, delay = body.order, len(ring)
    for row in range(rows):
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
        if same and far_apart(body.cogs, away, states[row * n], body) < margin:
            return row
    return -1


def has_period(period, rows, table):
    """Whether a proven orbit has a period that divides ``period``."""
    for row in range(rows):
        if table[row * FIELDS] == CYCLE_PROVEN and period % int(table[row * FIELDS + 1]) == 0:
            return True
    return False


def closes_in(z, before, ring, head, period, gap, body, wall, space):
    """Whether a trial that came back to within ``gap`` has the same readings again, and comes no less close.

    Motions with the same readings never part, so a candidate period that fails is none; this is cheaper than a proof.
    Where teeth part, or beside cogging, motions may part for a while, too, and only the readings are compared.
    ``space.trail`` has the readings of the period that led here, as far as it reaches.
    """
    n = body.order
    for j in range(n):
        space.state[j] = z[j]
    for j in range(len(ring)):
        space.line[j] = ring[j]
    plain = n == 2 and len(ring) == 0 and body.friction > 0.0 and wall.hysteresis == 0.0 and not has_cogs(body.cogs)
    for k in range(period):
        if body.halt[0] > 0.0:
            return False
        shown = read_after(space.state[0], before, wall)
        if k < len(space.trail) and inside(shown, wall) != inside(space.trail[k], wall):
            return False
        if plain:
            u = command(shown, before, wall)
            x, v = step_with_friction(space.state[0], space.state[1], u, 1.0, body.s2, body.g2, body.f2, body)
            space.state[0], space.state[1] = x, v
            before = shown
        else:
            before, head = advance(space.state, before, space.line, head, body, wall, space.pad)
    for j in range(n):
        space.away[j] = space.state[j] - z[j]
    return body.play > 0.0 or has_cogs(body.cogs) or gap_apart(body.cogs, space.away, body) <= gap


def contracts_to_rest(z, shown, before, ring, head, body, wall, space):
    """Whether, with a continuous sensor inside the wall, the loop is proven to bring a trial to rest.

    Then ``z`` and ``ring`` are left as they are there.
    """
    if wall.analog == 0.0 or not shown < 0.0:
        return False
    status, _, _, _, _ = certify(z, before, ring, head, 1, body, wall, space)
    if status != PROVEN:
        return False
    for j in range(body.order):
        z[j] = space.orbit[j]
    z[1] = 0.0
    for j in range(len(ring)):
        ring[j] = space.orbit_line[j]
    return True


def follow_trial(
    z,
    before,
    ring,
    head,
    budget,
    final,
    limit,
    body,
    wall,
    space,
    check,
    checkring,
    keep,
    keepring,
    rows,
    table,
    states,
    lines,
):
    """Follow a trial for at most ``budget`` samples: ``(fate, period, before, head, samples)``.

    ``z`` and ``ring`` are left at the orbit's state. ``check`` and ``keep`` (order), ``checkring`` and ``keepring``
    (delay) are work space. The ``rows`` of ``table``, ``states`` and ``lines`` are the attractors known already; where
    the trial reaches one of them, the fate is `KNOWN` and the period its row. ``final``: whether the trial gets no more
    samples than these, so that a last look at how it stands is worth it.
    """
    n, delay = body.order, len(ring)
    have, events, next_checkpoint, since = False, 0, 1, 0
    chead, tolerance = head, FIRST_TOLERANCE
    kept, kept_fate, kept_head, kept_before = 0, CYCLE_ON_EDGE, head, before
    resting_on_edge, settling = False, False
    shown = read(z[0], wall)
    level = depth_level(shown, wall)
    run, next_test = 0, FIRST_REST_TEST
    left_alone, wait = 0, 0
    for i in range(budget):
        x = z[0]
        if body.halt[0] > 0.0:
            return UNSETTLED, 0, before, head, i
        if has_gone(body.cogs, z, limit):
            return GREW, 0, before, head, i
        close = False
        for row in range(rows):
            if abs(x - states[row * n]) < table[row * FIELDS + 2] and table[row * FIELDS] == CYCLE_PROVEN:
                close = True
        if close and wall.analog == 0.0:
            row = captured(z, before, ring, head, body, wall, space.away, rows, table, states, lines)
            if row >= 0:
                return KNOWN, row, before, head, i
        last = shown
        shown = read_after(x, before, wall)
        level_before, level = level, depth_level(shown, wall)
        same = level == level_before if wall.analog == 0.0 else (shown < 0.0) == (last < 0.0)
        if same:
            run += 1
            if run >= next_test:
                next_test = 2 * run
                fate, _ = settles(z, shown, before, ring, body, wall, space.orbit, space.away)
                if fate == SETTLING:
                    settling = True
                    if stands(z, before, ring, head, body, wall, space):
                        fate = AT_REST
                if fate == AT_REST:
                    for j in range(n):
                        z[j] = space.orbit[j]
                    return REST_PROVEN, 1, shown if wall.hysteresis > 0.0 else before, head, i
                if fate == LEAVES:
                    return LEFT, 0, before, head, i
                if fate == RINGS:
                    return UNDAMPED, 0, before, head, i
                resting_on_edge = fate == REST_ON_EDGE
                if fate == MOVING and contracts_to_rest(z, shown, before, ring, head, body, wall, space):
                    return REST_PROVEN, 1, z[0], head, i
        else:
            run, next_test = 0, FIRST_REST_TEST
            resting_on_edge, settling = False, False
        if level < level_before and not jitters(wall.clock):
            if have:
                for j in range(n):
                    space.away[j] = z[j] - check[j]
                gap = gap_apart(body.cogs, space.away, body)
                if gap < tolerance and (wall.analog > 0.0 or same_line(ring, head, checkring, chead)):
                    status, margin = DIFFERENT, 0.0
                    known = wall.analog == 0.0 and has_period(since, rows, table)
                    if i < wait:
                        status = WAIT
                    elif known and gap > 0.0 and left_alone < PATIENCE:
                        # Probably an orbit known already, whose deepest sample will show it.
                        status, left_alone = WAIT, left_alone + 1
                        tolerance = 0.25 * gap
                    elif wall.analog > 0.0 or closes_in(z, before, ring, head, since, gap, body, wall, space):
                        status, margin, _, _, _ = certify(z, before, ring, head, since, body, wall, space)
                        if wall.analog > 0.0:
                            wait = i + PROOF_COST * since
                        if status == NEUTRAL and body.friction > 0.0:
                            status = DIFFERENT  # held by friction: no cycle
                    if status == PROVEN or status == NEUTRAL:
                        for j in range(n):
                            z[j] = space.orbit[j]
                        for j in range(delay):
                            ring[j] = space.orbit_line[j]
                        fate = CYCLE_PROVEN if status == PROVEN else CYCLE_CONTINUUM
                        return fate, since, space.reading[0], head, i
                    if status == ON_EDGE or status == AT_EVENT or status == EXPANDS or status == PARTS:
                        kept, kept_head, kept_before = since, head, space.reading[0]
                        kept_fate = CYCLE_ON_EDGE
                        if status != ON_EDGE:
                            kept_fate = CYCLE_AT_EVENT if status == AT_EVENT else CYCLE_EXPANDS
                        if status == PARTS:
                            kept_fate = CYCLE_PARTS
                        for j in range(n):
                            keep[j] = space.orbit[j]
                        for j in range(delay):
                            keepring[j] = space.orbit_line[j]
                        if status == PARTS:
                            for j in range(n):
                                space.away[j] = z[j] - keep[j]
                            if gap_apart(body.cogs, space.away, body) < BESIDE:
                                for j in range(n):
                                    z[j] = keep[j]
                                for j in range(delay):
                                    ring[j] = keepring[j]
                                return CYCLE_PARTS, since, kept_before, head, i
                    if status != WAIT:
                        tolerance = 0.5 * gap
                    if status == NOT_CAPTURED:
                        for j in range(n):
                            space.away[j] = z[j] - space.orbit[j]
                        away = gap_apart(body.cogs, space.away, body)
                        tolerance = gap * min(1.0, 0.9 * margin / away) if away > 0.0 else 0.5 * gap
                    elif status == DIFFERENT and gap == 0.0:
                        tolerance = FIRST_TOLERANCE
            events += 1
            if events == next_checkpoint:
                next_checkpoint = 2 * events
                have, since = True, 0
                chead, tolerance = head, FIRST_TOLERANCE
                for j in range(n):
                    check[j] = z[j]
                for j in range(delay):
                    checkring[j] = ring[j]
        if since < len(space.trail):
            space.trail[since] = shown
        since += 1
        if jitters(wall.clock):
            before, head = advance_jittering(z, before, ring, head, body, wall, space.pad)
        elif (
            body.order == 2
            and delay == 0
            and body.friction > 0.0
            and wall.hysteresis == 0.0
            and not has_cogs(body.cogs)
        ):
            u = command(shown, before, wall)
            z[0], z[1] = step_with_friction(x, z[1], u, 1.0, body.s2, body.g2, body.f2, body)
            before = shown
        else:
            before, head = advance(z, before, ring, head, body, wall, space.pad)
    if not final:  # what has repeated without proof may yet be left, or proven
        return (UNSETTLED if body.damped else UNDAMPED), 0, before, head, budget
    if kept > 0:
        for j in range(n):
            z[j] = keep[j]
        for j in range(delay):
            ring[j] = keepring[j]
        return kept_fate, kept, kept_before, kept_head, budget
    if resting_on_edge:
        fate, _ = settles(z, shown, before, ring, body, wall, space.orbit, space.away)
        if fate == REST_ON_EDGE:
            for j in range(n):
                z[j] = space.orbit[j]
        return REST_EDGE, 1, before, head, budget
    # The tests grow rare: without one more, the share at rest could fall when the limit is raised.
    shown = read_after(z[0], before, wall)
    fate, _ = settles(z, shown, before, ring, body, wall, space.orbit, space.away)
    if settling or fate == SETTLING or fate == AT_REST:
        for j in range(n):
            z[j] = space.orbit[j]
        return REST_PROVEN, 1, shown if wall.hysteresis > 0.0 else before, head, budget
    if fate == MOVING and contracts_to_rest(z, shown, before, ring, head, body, wall, space):
        return REST_PROVEN, 1, z[0], head, budget
    return (UNSETTLED if body.damped else UNDAMPED), 0, before, head, budget
