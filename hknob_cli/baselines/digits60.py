"""The reference: the same model to 60 digits, by matrix exponentials, its events located to 60 digits.

A scene is linear between events. Every duration is a sum of T / 2^j, so the exponentials of the matrices over these are
all there is to compute: a hold is a product of some of them, and an event is bisected by them to the last bit.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from hknob_cli.baselines.model import Controller, Deadline, LostError, bias_torque, build_plant, leaves, start_state
from hknob_cli.errors import UsageError
from hknob_cli.specs.plan import BenchScene

DIGITS = 60
BITS = 220  # T / 2^BITS is the resolution of events
_GUARD = 20
_TERMS = 8  # of the exponential over the shortest time, whose argument is below 2^-100
_FASTEST = 2.0 ** (BITS - 100)  # norm of the matrix, a sample interval
_MOST_EVENTS = 100_000

State = list[Any]
Matrix = list[list[Any]]
Event = Callable[[State], Any]  # positive until it happens


def context() -> Any:
    """A context of 60 digits and some, of its own. Raises `UsageError` without mpmath."""
    try:
        import mpmath
    except ImportError:
        raise UsageError(
            "reference: digits60 needs mpmath, which is not installed: pip install mpmath, or choose reference: exact"
        ) from None
    mp = mpmath.MPContext()
    mp.dps = DIGITS + _GUARD
    return mp


class Digits60:
    """See `run.Integrator`."""

    def __init__(self, trial: BenchScene, mp: Any, deadline: Deadline) -> None:
        """Make ready, in the context ``mp``. Raises `LostError` where a motion is too fast for the resolution."""
        import numpy as np

        self.mp, self.deadline = mp, deadline
        self.controller = Controller(trial, mp.mpf, mp.floor, 2 * mp.pi)
        self.plant = build_plant(trial.scene, mp.mpf)
        self.bias = bias_torque(trial.scene, self.controller.quantum, mp.mpf)
        self.order = self.plant.order
        analog = not trial.scene.sampled and not self.controller.rounding
        generators = [self._generator(stuck=False, inside=inside) for inside in {False, analog}]
        matrices = np.array([[[float(x) for x in row] for row in generator] for generator in generators])
        period = float(self.controller.period)
        if not np.linalg.norm(matrices, np.inf, axis=(1, 2)).max() * period < _FASTEST:
            raise LostError("its motion is too fast for the sample interval")
        rates = np.linalg.eigvals(matrices)
        # Events are looked for on a net that no mode can slip through: short at first, then as the slow modes allow.
        self.finest = _halvings(16.0 * period * (abs(rates).max() + 1.0 / period))
        self.coarsest = _halvings(8.0 * period * (abs(rates.imag).max() + 0.5 / period))
        self._tables: dict[tuple[bool, bool], list[Matrix]] = {}
        self._products: dict[int, Matrix] = {}
        self.level: int | None = None
        self.steps = 0

    def start(self, trial: BenchScene) -> State:
        """State at the start; last, command and other torque on the knob."""
        return [*start_state(trial, self.plant, self.mp.mpf), self.mp.mpf(0), self.mp.mpf(0)]

    def hold(self, state: State, command: Any, duration: Any) -> State:
        """State after a constant command."""
        if self.plant.friction > 0:
            return self._flow(state, command, self._ticks(duration), (None, None), inside=False)[1]
        ticks = self._ticks(duration)
        if ticks not in self._products:
            table = self._table(stuck=False, inside=False)
            product: Matrix | None = None
            for j in _bits(ticks):
                product = table[j] if product is None else self._times(table[j], product)
            assert product is not None
            self._products[ticks] = product
        self.steps += 1
        return self._apply(self._products[ticks], self._driven(state, command, 0))

    def free(self, state: State, duration: Any) -> State:
        """State after a time under the controller without a clock."""
        ticks = self._ticks(duration)
        while ticks > 0:
            if self.level is None:
                self.level = self.controller.level(state[0])
            command, bounds = self.controller.without_clock(self.level)
            inside = not self.controller.rounding and self.level < 0
            elapsed, state, way = self._flow(state, command, ticks, bounds, inside=inside)
            self.level += way
            ticks -= elapsed
        return state

    def _flow(
        self, state: State, command: Any, ticks: int, bounds: tuple[Any, Any], *, inside: bool
    ) -> tuple[int, State, int]:
        """Move until the time is over or the angle leaves ``bounds``: time taken, state, -1 or 1 where it left."""
        low, high = bounds
        gone, level = 0, self.plant.friction
        loose = 0
        while gone < ticks:
            self.steps += 1
            self.deadline.look()
            if self.steps > _MOST_EVENTS:
                raise LostError(f"more than {_MOST_EVENTS} events")
            events = leaves(low, high)
            stuck, way = False, 0
            state = self._driven(state, command, 0)
            if level > 0:
                force = self._force(state, inside)
                stuck = state[1] == 0 and abs(force) <= level and not loose
                if stuck:
                    events.append((partial(self._hold_of, inside=inside), 0))
                else:
                    way = loose or (1 if (state[1] or force) > 0 else -1)
                    events.append((partial(_speed, way), 0))
                    state = self._driven(state, command, -way * level)
            loose = 0
            table = self._table(stuck=stuck, inside=inside)
            elapsed, state, happened = self._search(table, state, ticks - gone, events)
            gone += elapsed
            if happened is None:
                break
            if events[happened][1]:
                return gone, state, events[happened][1]
            if stuck:
                loose = 1 if self._force(state, inside) > 0 else -1
            else:
                state[1] = self.mp.mpf(0)
        return ticks, state, 0

    def _search(
        self, table: list[Matrix], state: State, ticks: int, events: list[tuple[Event, int]]
    ) -> tuple[int, State, int | None]:
        """Move up to the first event: time taken, state just before it, number of the event."""
        gone, j = 0, self.finest
        while gone < ticks:
            self.deadline.look()  # a stiff scene has a net of millions
            while BITS - j > 0 and (1 << (BITS - j)) > ticks - gone:
                j += 1
            after = self._apply(table[j], state)
            if any(event(after) < 0 for event, _ in events):
                return self._bisect(table, state, gone, j, events)
            state = after
            gone += 1 << (BITS - j)
            if j > self.coarsest:
                j -= 1
        return ticks, state, None

    def _bisect(
        self, table: list[Matrix], state: State, gone: int, piece: int, events: list[tuple[Event, int]]
    ) -> tuple[int, State, int | None]:
        """The last moment before the first event in a piece in which one happens."""
        happened = None
        for j in range(piece, BITS + 1):
            after = self._apply(table[j], state)
            late = [i for i, (event, _) in enumerate(events) if event(after) < 0]
            if late:
                happened = late[0]
            else:
                state = after
                gone += 1 << (BITS - j)
        return gone + 1, state, happened

    def _driven(self, state: State, command: Any, friction: Any) -> State:
        """The state with command and other torque in place."""
        return [*state[: self.order], command, friction - self.bias]

    def _force(self, z: State, inside: bool) -> Any:
        """Torque on the knob except for friction."""
        row = self._generator(stuck=False, inside=inside)[1]
        known = [*z[: self.order], z[self.order], -self.bias]
        return self.plant.inertia * self.mp.fdot(zip(row, known, strict=True))

    def _hold_of(self, z: State, *, inside: bool) -> Any:
        """What friction could still hold at rest, N·m."""
        return self.plant.friction - abs(self._force(z, inside))

    def _generator(self, *, stuck: bool, inside: bool) -> Matrix:
        """Matrix of the state with its two inputs; ``inside`` the wall of a continuous controller."""
        zero = self.mp.mpf(0)
        rows = [[*row, b, c] for row, b, c in zip(self.plant.a, self.plant.b, self.plant.c, strict=True)]
        if inside:
            rows[1][0] -= self.controller.stiffness / self.plant.inertia
        if stuck:
            rows[1] = [zero] * (self.order + 2)
        return [*rows, [zero] * (self.order + 2), [zero] * (self.order + 2)]

    def _table(self, *, stuck: bool, inside: bool) -> list[Matrix]:
        """Exponentials over T / 2^j for j from 0 to BITS, squared up from the shortest with digits to spare."""
        if (stuck, inside) not in self._tables:
            mp, usual = self.mp, self.mp.dps
            mp.dps = 3 * DIGITS + _GUARD  # each squaring doubles the relative error
            try:
                generator = self._generator(stuck=stuck, inside=inside)
                size = range(len(generator))
                step = self.controller.period / (mp.mpf(2) ** BITS)
                small = [[x * step for x in row] for row in generator]
                one = [[mp.mpf(int(i == j)) for j in size] for i in size]
                matrix = one
                for term in range(_TERMS, 0, -1):
                    product = self._times(small, matrix)
                    matrix = [[one[i][j] + product[i][j] / term for j in size] for i in size]
                table = [matrix]
                for _ in range(BITS):
                    table.append(self._times(table[-1], table[-1]))
            finally:
                mp.dps = usual
            self._tables[stuck, inside] = [[[+x for x in row] for row in matrix] for matrix in reversed(table)]
        return self._tables[stuck, inside]

    def _ticks(self, duration: Any) -> int:
        """A duration in T / 2^BITS, at most T."""
        return int(self.mp.nint(duration / self.controller.period * 2**BITS))

    def _times(self, left: Matrix, right: Matrix) -> Matrix:
        columns = list(zip(*right, strict=True))
        return [[self.mp.fdot(zip(row, column, strict=True)) for column in columns] for row in left]

    def _apply(self, matrix: Matrix, state: State) -> State:
        return [self.mp.fdot(zip(row, state, strict=True)) for row in matrix]


def _speed(way: int, z: State) -> Any:
    """Speed of the knob one way."""
    return way * z[1]


def _halvings(pieces: float) -> int:
    """How often a period is halved to be cut into at least so many pieces."""
    return max(0, int(pieces).bit_length())


def _bits(ticks: int) -> list[int]:
    """The j of the T / 2^j that sum up to ``ticks``."""
    return [j for j in range(BITS + 1) if ticks >> (BITS - j) & 1]
