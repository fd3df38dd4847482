"""When a continuous sensor's motion is worth a look: no count tells that it has turned, or that it stands still."""

from hknob_cli.engine.general.cogging import gap_apart

LOOK_AGAIN = 64  # samples after which a motion that may stand still is compared
CLOSE = 1e-12  # of a position: so close it has come to a standstill


def turn_level(shown, last, level):
    """Level that falls where a motion has turned down: beside a curve an event that no cycle lacks."""
    if shown == last:
        return level
    return 1.0 if shown > last else 0.0


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
