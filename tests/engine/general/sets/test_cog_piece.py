"""Tests of pieces beside cogging: states in them, each followed by itself, are in what is made of them."""

import random
from collections.abc import Iterator
from typing import Any

import pytest

from hknob_cli.engine.attractors import Patience, StoppedError
from hknob_cli.engine.general.cogging import CENTRE, LENGTH, slope_at, unit_reach
from hknob_cli.engine.general.sets import lattice, search
from hknob_cli.engine.general.sets.cog_piece import Folds, cross_hold, halve_piece, put_round, size_of_piece
from hknob_cli.engine.general.sets.cog_search import CogSetEngine, can_follow_cogged
from hknob_cli.engine.general.sets.convex import hull
from hknob_cli.engine.general.sets.friction_arc import ERROR, STATE
from hknob_cli.engine.general.sets.friction_arc_search import make_rub_room, rub_drift
from hknob_cli.engine.general.sets.room import make_piece_room
from hknob_cli.engine.general.slopes import cog_acceleration, cog_many
from hknob_cli.engine.sets.search import Box
from hknob_cli.scene.general_knob import GeneralKnob
from tests.engine.general.bodies import knob

from .cells import zeros

ROOM = 128


def cell(friction: float, torque: float, places: int, rate: float) -> GeneralKnob:
    """A knob beside cogging with so many places."""
    return knob(
        rate,
        knob={"inertia": 1.9e-6, "coulomb_torque": friction},
        cogging={"torque": torque, "per_revolution": places, "centre": 0.03},
    )


class Piece:
    """A piece at a hold's beginning, some of its states, and a torque."""

    def __init__(self, one: GeneralKnob, chance: random.Random) -> None:
        body = self.body = one.body
        away, stiff = body.cogs[LENGTH], unit_reach(body)
        self.drift, self.room = rub_drift(body, one.wall), make_rub_room(zeros, list, body, one.wall, 0, None)
        self.folds = Folds(zeros(ROOM), zeros(ROOM), zeros(2 * ROOM), zeros(ROOM))
        size = away * 10.0 ** chance.uniform(-4.0, -0.3)
        many, wide = chance.randint(3, 9), 10.0 ** chance.uniform(-1.0, 1.0)
        points = [chance.gauss(0.0, size * (wide / stiff if k % 2 else 1.0)) for k in range(2 * many)]
        self.corners = zeros(ROOM + 2)
        self.count = hull(points, many, self.corners)
        speed = chance.choice([size / stiff, 10.0 ** chance.uniform(-4.0, 0.0) * away, body.friction + 1e-3])
        z = [chance.uniform(-1.0, 3.0) * away, chance.gauss(0.0, speed)]
        if chance.random() < 0.4:  # beside a corner
            z[0] = body.cogs[CENTRE] + (chance.randint(-1, 2) + 0.5) * away + chance.gauss(0.0, size)
        self.stands = body.friction > 0.0 and chance.random() < 0.15
        if self.stands:
            z[1] = 0.0
            self.corners[:4] = [-size, 0.0, size, 0.0]
            self.count = 2
        self.span = chance.choice([1.0, 1.0, chance.uniform(0.05, 1.0)])
        self.room.z[:], self.room.arc[:] = z, zeros(STATE)
        self.room.arc[ERROR] = 1e-14 * (abs(z[0]) + abs(z[1]))
        pull = float(cog_acceleration(z, 0.0, slope_at(z[0], body.cogs), body))
        way, some = (1.0 if z[1] > 0.0 else -1.0), 1.0 + 1e-6 * chance.random()
        self.u = chance.choice(
            [
                chance.gauss(0.0, away) * 10.0 ** chance.uniform(-3.0, 0.0),
                chance.choice([-1.0, 1.0]) * body.friction * chance.uniform(0.8, 1.2) - pull,
                way * body.friction * some - pull - z[1] / (chance.uniform(0.0, 1.2) * self.span + 1e-6),
                body.friction * chance.uniform(-1.0, 1.0) - pull,
            ]
        )
        self.states = [self.state(chance) for _ in range(12)]

    def state(self, chance: random.Random) -> list[float]:
        """One of it, also on its edges."""
        parts = [chance.random() ** 4 for _ in range(self.count)]
        if chance.random() < 0.5:
            one, other, part = chance.randrange(self.count), chance.randrange(self.count), chance.random()
            parts = [part * (k == one) + (1.0 - part) * (k == other) for k in range(self.count)]
        whole = sum(parts)
        x, v = (sum(part * self.corners[2 * k + j] for k, part in enumerate(parts)) / whole for j in range(2))
        return [self.room.z[0] + x, 0.0 if self.stands else self.room.z[1] + v]

    def move(self) -> float:
        """Over the hold; by what part it has grown more."""
        given = self.room, self.folds, self.corners, self.count, self.u, self.span, self.drift, self.body
        self.count, loose = cross_hold(*given)
        for state in self.states:
            cog_many(self.body.cogs, state, self.u, self.span, self.body, zeros(4))
        return float(loose)

    def outside(self) -> Iterator[float]:
        """How far states are from it, beside what its centre may be off."""
        error, z, corners, count = self.room.arc[ERROR], self.room.z, self.corners, self.count
        more = unit_reach(self.body) * error + 1e-13 * (1.0 + abs(z[0]))
        error += 1e-13 * (1.0 + abs(z[0]))
        for x, v in ((one[0] - z[0], one[1] - z[1]) for one in self.states):
            if count == 2:
                yield max(abs(v) - error, abs(x) - max(abs(corners[0]), abs(corners[2])) - more)
                continue
            for k in range(count):
                j = (k + 1) % count
                along, up = corners[2 * j] - corners[2 * k], corners[2 * j + 1] - corners[2 * k + 1]
                side = along * (v - corners[2 * k + 1]) - up * (x - corners[2 * k])
                yield -side - abs(along) * error - abs(up) * more


CELLS: dict[str, tuple[float, float, int, float]] = {
    "nothing rubs": (0.0, 3e-4, 84, 1000.0),
    "strong": (0.0, 3e-3, 84, 464.0),
    "many corners": (0.0, 1e-3, 400, 2154.0),
    "friction": (1e-4, 3e-4, 84, 1000.0),
    "friction, fast": (1e-4, 1e-3, 84, 10_000.0),
    "friction, many corners": (1e-4, 1e-3, 400, 464.0),
    "much friction": (5.6e-4, 3e-3, 84, 464.0),
}


def check(one: GeneralKnob, seed: int, many: int) -> int:
    """Of how many random pieces little was lost; none of their states is elsewhere."""
    tight = 0
    for k in range(many):
        piece = Piece(one, random.Random(1000 * seed + k))
        tight += piece.move() < 0.3
        assert max(piece.outside()) <= 0.0, (seed, k)
    return tight


@pytest.mark.parametrize("name", CELLS)
def test_states_are_in_what_is_made_of_their_piece(name: str) -> None:
    assert check(cell(*CELLS[name]), 0, 60) > 3


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 9))
@pytest.mark.parametrize("name", CELLS)
def test_states_of_more_pieces_are_in_what_is_made_of_them(name: str, seed: int) -> None:
    check(cell(*CELLS[name]), seed, 1000)


def test_halves_are_all_of_a_piece_and_shorter() -> None:
    body = cell(0.0, 3e-4, 84, 1000.0).body
    room = make_piece_room(zeros, 2, 0, lattice=2, deep=2)
    corners = zeros(ROOM)
    count = put_round(corners, 1.0, False, body)
    one, other = halve_piece(room, corners, count, body)
    assert size_of_piece(corners, count, body) == pytest.approx(1.0823922, rel=1e-6)
    assert {round(room.halves[2 * k] + room.halves[2 * k + 1], 9) for k in range(one)} & {
        round(room.parts[2 * k] + room.parts[2 * k + 1], 9) for k in range(other)
    }
    assert one + other >= count + 2


@pytest.mark.parametrize(
    ("more", "able"),
    [
        ({}, True),
        ({"actuator": {"delay_samples": 1.4}}, True),
        ({"cogging": {"torque": 7e-4, "per_revolution": 84}}, True),
        ({"cogging": {"torque": 8e-4, "per_revolution": 84}}, False),  # slope 0.043, the hand's spring 0.04 N·m/rad
        ({"encoder": {"hysteresis_counts": 0.5}}, False),
        ({"actuator": {"time_constant": 3e-4}}, False),
        ({"cogging": {"torque": 0.0, "per_revolution": 84}}, False),
    ],
)
def test_a_knob_alone_is_followed(more: dict[str, Any], able: bool) -> None:
    one = knob(1000.0, **{"cogging": {"torque": 3e-4, "per_revolution": 84}, **more})
    assert can_follow_cogged(one.body, one.wall) == able


@pytest.mark.parametrize("friction", [0.0, 5.6e-4])
def test_a_small_box_is_followed_to_its_end(friction: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "SAMPLED", 8)
    one = cell(friction, 3e-4, 84, 464.0)
    engine = CogSetEngine(patience=Patience(samples=2**40, seconds=60.0))
    found = engine.search_box(
        one.body, one.wall, Box(-0.61, -0.6, 0.0, 0.01), rate=one.rate, delay_line=0, max_samples=None
    )
    assert found
    assert found.complete
    assert all(end.certified for end in found.attractors)


def test_a_search_is_not_changed_by_one_that_was_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """On one engine, whose lattice still had pieces of it: those of the next search that met them were lost."""
    monkeypatch.setattr(search, "SAMPLED", 0)
    one = cell(0.0, 3e-4, 84, 464.0)
    engine = CogSetEngine(patience=Patience(samples=2**40, seconds=60.0))

    def ends(engine: CogSetEngine) -> Any:
        states = Box(-1.0, 1.0, -0.2, 0.2)
        return engine.search_box(one.body, one.wall, states, rate=one.rate, delay_line=0, max_samples=None)

    with monkeypatch.context() as patch:
        patch.setattr(lattice, "release", given_up)
        with pytest.raises(StoppedError):
            ends(engine)
    (room,) = engine._rooms.values()
    assert room.counts[0] > 0.0
    again = ends(engine)
    assert again == ends(CogSetEngine(patience=engine.patience))
    assert again.complete


def given_up(*_: Any) -> int:
    raise StoppedError
