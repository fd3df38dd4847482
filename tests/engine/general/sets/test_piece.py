"""Tests of `engine.general.sets.piece`, `lattice` and `box`: no state is lost by cutting, moving and merging."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets.box import fill_box
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.lattice import keep, release
from hknob_cli.engine.general.sets.parts import part
from hknob_cli.engine.general.sets.piece import (
    BEFORE,
    CORNERS,
    COUNT,
    ERROR,
    STATE,
    WEIGHT,
    largest_norm,
    piece_size,
)
from hknob_cli.engine.general.sets.readings import acting, count_levels, remembered
from hknob_cli.engine.general.sets.room import PieceRoom, hash_scale, make_piece_room
from hknob_cli.scene.general_knob import GeneralKnob

from .cells import KINDS, SECOND, bounds, cell, centre, kinds, nothing_known, rates, zeros

quick = settings(deadline=None, max_examples=20)
ROOMS: dict[tuple[int, int], PieceRoom] = {}


def room_of(knob: GeneralKnob) -> PieceRoom:
    """Work space of the interpreter, made once."""
    key = knob.body.order, knob.delay_line
    if key not in ROOMS:
        ROOMS[key] = make_piece_room(zeros, *key, lattice=128, deep=128)
    return ROOMS[key]


def polygon(knob: GeneralKnob, chance: np.random.Generator, corners: int, size: float) -> np.ndarray:
    """A convex polygon about 0, in a plane of the space of all states; in the order of its corners."""
    n = knob.body.order
    angles = np.sort(chance.uniform(0.0, 2.0 * np.pi, corners))
    plane = chance.normal(size=(2, n))
    plane[:, 0] *= size
    plane[:, 1:] *= size / knob.body.reach
    if knob.body.lag > 0.0:
        plane[:, n - 1] *= knob.body.lag
    return np.column_stack([np.cos(angles), np.sin(angles)]) @ plane


def members(corners: np.ndarray, chance: np.random.Generator, count: int) -> np.ndarray:
    """Random states of a polygon, its corners among them."""
    shares = chance.dirichlet(np.full(len(corners), 0.4), count)
    return np.vstack([corners, shares @ corners])


def off(state: np.ndarray, corners: np.ndarray, units: np.ndarray) -> float:
    """Distance of a state from a point of the hull of some corners, near the nearest, in the units of the norm.

    The shares are those of a fit in which their sum is 1 nearly; made to sum to 1 they are a point of the hull, whose
    distance is told without the fit's roundings.
    """
    from scipy.optimize import nnls

    scale = units[:, None] / max(1e-300, np.abs(corners * units).max())
    weight = 100.0  # of the shares' sum
    shares, _ = nnls(np.vstack([corners.T * scale, np.full(len(corners), weight)]), [*(state * scale[:, 0]), weight])
    apart = np.longdouble(state) - np.longdouble(corners).T @ np.longdouble(shares / shares.sum())
    return float(np.sqrt(((apart * units) ** 2).sum()))


def pieces_of(room: PieceRoom, waiting: int, knob: GeneralKnob) -> list[tuple[np.ndarray, np.ndarray, list[float]]]:
    """Centre, corners, and the list of each piece that waits."""
    n, delay = knob.body.order, knob.delay_line
    size = piece_size(n, delay)
    found = []
    for k in range(waiting):
        one = room.stack[k * size : (k + 1) * size]
        count, at = int(one[COUNT]), STATE + n + delay
        found.append((np.array(one[STATE : STATE + n]), np.array(one[at : at + count * n]).reshape(count, n), one))
    return found


@quick
@given(kind=kinds, rate=rates, seed=st.integers(0, 2**32 - 1), corners=st.integers(2, CORNERS))
def test_cutting_and_moving_lose_no_state(kind: str, rate: float, seed: int, corners: int) -> None:
    """Each state, moved by itself by what it reads, is in a piece with its own commands and its own last reading."""
    knob, chance = cell(kind, rate), np.random.default_rng(seed)
    body, wall, drift, room = knob.body, knob.wall, bounds(knob), room_of(knob)
    n, delay = body.order, knob.delay_line
    z = [float(chance.uniform(-6.0, 3.0)), *(float(v) for v in chance.normal(size=n - 1) / body.reach)]
    shape = polygon(knob, chance, corners, 10.0 ** chance.uniform(-3.0, 0.5))
    flat = shape.ravel().tolist()
    ring = [float(wall.kappa * chance.integers(0, 5)) for _ in range(delay)]
    before = remembered(float(chance.integers(-5, 3)), wall)
    head = int(chance.integers(0, delay)) if delay else 0
    least, most = (z[0] + value for value in (shape[:, 0].min(), shape[:, 0].max()))
    low, high = acting(least - 1e-9, drift.bottom, wall), acting(most + 1e-9, drift.bottom, wall)
    error = 1e-10 / body.reach
    room.corners[: len(flat)] = flat
    told = centre(z, ring, before, head=head, error=error)
    waiting = part(room, 0, told, corners, low, high, 1e-10, Cell(drift, nothing_known(knob), body, wall))
    assert waiting >= count_levels(low, high, wall) or corners == 2
    found = pieces_of(room, waiting, knob)
    units = np.array(drift.units)
    for one in members(shape, chance, 20):
        state, line = [float(v) for v in np.array(z) + one], list(ring)
        shown, to = advance(state, before, line, head, body, wall, zeros(2 * n))
        line = [line[(to + j) % delay] for j in range(delay)]
        near = [
            (off(np.array(state) - centre, shape, units), piece)
            for centre, shape, piece in found
            if piece[STATE + n : STATE + n + delay] == line and piece[BEFORE] == remembered(shown, wall)
        ]
        assert near, "no piece has these commands"
        assert any(away <= 2.0 * piece[ERROR] + 1e-9 / body.reach for away, piece in near)


@quick
@given(kind=kinds, seed=st.integers(0, 2**32 - 1))
def test_a_box_is_filled_with_all_its_starts(kind: str, seed: int) -> None:
    """Every start in it, the finger moving with the knob, is in a piece that remembers its own reading."""
    knob, chance = cell(kind), np.random.default_rng(seed)
    body, wall, drift, room = knob.body, knob.wall, bounds(knob), room_of(knob)
    box = (*sorted(chance.uniform(-8.0, 8.0, 2)), *sorted(chance.uniform(-3.0, 3.0, 2)))
    waiting = fill_box(box, room, None, drift, body, wall)
    found = pieces_of(room, waiting, knob)
    assert sum(piece[WEIGHT] for _, _, piece in found) == pytest.approx(1.0)
    units = np.array(drift.units)
    for _ in range(20):
        state = np.zeros(body.order)
        state[:2] = chance.uniform(*box[:2]), chance.uniform(*box[2:])
        shown = read(float(state[0]), wall)
        away = [
            off(state - centre, shape, units)
            for centre, shape, piece in found
            if piece[BEFORE] == remembered(shown, wall)
        ]
        assert min(away) < 1e-9


@settings(deadline=None, max_examples=10)
@given(kind=st.sampled_from(SECOND), seed=st.integers(0, 2**32 - 1))
def test_merging_loses_no_state_and_mixes_no_memory(kind: str, seed: int) -> None:
    """What goes on from a cell of the lattice holds all its members with these commands and this last reading."""
    knob, chance = cell(kind), np.random.default_rng(seed)
    body, wall, drift, room = knob.body, knob.wall, bounds(knob), room_of(knob)
    delay, width = knob.delay_line, 0.5
    room.scale[0] = hash_scale(wall)
    given_in = []
    for _ in range(16):
        z = [float(chance.uniform(-0.5, 0.5)), float(chance.uniform(-0.5, 0.5) / body.reach)]
        ring = [float(wall.kappa * chance.integers(0, 2)) for _ in range(delay)]
        before = remembered(float(chance.integers(-1, 1)), wall)
        shape = polygon(knob, chance, 5, 0.05)
        flat, error = shape.ravel().tolist(), 1e-9
        told = centre(z, ring, before, error=error, sample=3.0, weight=0.1)
        assert keep(room, told, flat, 5, width, drift, body)
        given_in.append((np.array(z), shape, ring, before))
    found = pieces_of(room, release(room, 0, delay, drift), knob)
    assert len(found) < 16
    assert sum(piece[WEIGHT] for _, _, piece in found) == pytest.approx(1.6)
    units = np.array(drift.units)
    for z, shape, ring, before in given_in:
        for one in members(shape, chance, 1):
            away = [
                off(z + one - centre, corners, units)
                for centre, corners, piece in found
                if piece[STATE + 2 : STATE + 2 + delay] == ring and piece[BEFORE] == before
            ]
            assert min(away) < 1e-9
    assert room.counts[0] == 0.0


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_radius_holds_every_state(kind: str) -> None:
    """The norm is convex: no state is farther from the centre than the farthest corner."""
    knob, chance = cell(kind), np.random.default_rng(7)
    shape = polygon(knob, chance, 9, 1.0)
    radius = largest_norm(shape.ravel().tolist(), 0, 9, knob.body)
    for one in members(shape, chance, 50):
        assert largest_norm(one.tolist(), 0, 1, knob.body) <= radius * (1.0 + 1e-12)
