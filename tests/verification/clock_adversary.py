"""Clocks that are chosen to make a knob swing: many motions at once, each by a rule of its own.

A rule has the shortest or the longest interval by the quadrant of the state about a centre, and now and then any. The
hold is that of `engine.propagator`, which `test_propagator` compares with 60 digits.
"""

from typing import NamedTuple

import numpy as np

from hknob_cli.engine.general.controller import command, read
from hknob_cli.engine.general.interval import SHORTEST
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.scene.general_knob import GeneralKnob

CHOICES = 5  # lengths of an interval
INSTANTS = 17  # within a hold, at which its position is looked at
DEEPEST = 400  # counts either way, of which commands are known


class Played(NamedTuple):
    """What motions do in the second half of a run: range of positions of each (n,), and their speeds at the end."""

    ranges: np.ndarray
    speeds: np.ndarray


def play(knob: GeneralKnob, start: list[float], *, rules: int, samples: int, seed: int = 0) -> Played:
    """Run ``rules`` motions, counts and longest intervals."""
    body, wall, chance = knob.body, knob.wall, np.random.default_rng(seed)
    commands = np.array([command(s := read(n + 0.5, wall), s, wall) for n in range(-DEEPEST, DEEPEST)])
    lengths = np.linspace(float(wall.clock[SHORTEST]), 1.0, CHOICES)
    steps = np.array([hold_coefficients(body.alpha, body.beta, t) for t in lengths])
    looks = np.linspace(0.0, 1.0, INSTANTS)
    within = np.array([hold_coefficients(body.alpha, body.beta, t) for t in looks])
    s, g, f = np.array([hold_coefficients(body.alpha, body.beta, t) for t in chance.random(rules)]).T
    y = body.drive - body.beta * start[0]
    x, v = start[0] + s * start[1] + g * y, f * start[1] + s * y
    centre, pace = chance.uniform(-3.0, 1.5, rules), chance.normal(0.0, 0.1, rules)
    longest = chance.integers(0, 2, (rules, 4)) > 0
    noise = chance.choice([0.0, 0.0, 0.05, 0.2, 1.0], rules)
    least, most = np.full(rules, np.inf), np.full(rules, -np.inf)
    every = np.arange(rules)
    for k in range(samples):
        y = commands[np.floor(x).astype(int) + DEEPEST] + body.drive - body.beta * x
        chosen = np.where(longest[every, (x > centre) + 2 * (v > pace)], CHOICES - 1, 0)
        chosen = np.where(chance.random(rules) < noise, chance.integers(0, CHOICES, rules), chosen)
        if k >= samples // 2:
            for at, (s_at, g_at, _) in zip(looks, within, strict=True):
                there = np.where(at <= lengths[chosen] + 1e-12, x + s_at * v + g_at * y, x)
                least, most = np.minimum(least, there), np.maximum(most, there)
        s, g, f = steps[chosen].T
        x, v = x + s * v + g * y, f * v + s * y
    return Played(most - least, v)
