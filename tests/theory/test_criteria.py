"""The criteria of section 6.2: each against another computation of the same condition, and how their limits scale."""

from math import inf, pi

import numpy as np
import pytest
from scipy.optimize import linprog, minimize_scalar

from hknob_cli.specs.plan import Bias, Encoder, Hand, Knob, Scene, Wall
from hknob_cli.theory.criteria import CRITERIA, Case, Criterion, case_of
from hknob_cli.theory.laws import WorkingEdge, working_edge
from hknob_cli.theory.passivity import needed_damping
from hknob_cli.theory.sampled_plant import sampled_plant
from tests.theory.jury import stable_by_jury
from tests.theory.test_laws import PLANTS, edge
from tests.theory.test_sampled_plant import in_z, response

OMEGAS = np.unique(np.concatenate([np.geomspace(1e-4, pi, 400), np.linspace(1e-4, pi, 600)]))


def case(plant: WorkingEdge, *, knob_share: float = 0.6, steepest: float = inf) -> Case:
    """A plant, of whose damping and inertia the knob has a share."""
    return Case(plant._replace(knob_damping=knob_share * plant.damping), 0.9 * plant.inertia, steepest)


def word(name: str, plant: WorkingEdge, **options: float) -> Criterion:
    return CRITERIA[name](case(plant, **options))


def with_hand(plant: WorkingEdge) -> np.ndarray:
    """Frequency response of knob and hand at `OMEGAS`, by the matrix exponential."""
    body = {"inertia": plant.inertia, "damping": plant.damping, "stiffness": plant.hand_stiffness}
    delay = plant.transport_s / plant.period_s
    return response(body, plant.period_s, delay, OMEGAS)


@pytest.fixture(scope="module", params=PLANTS)
def known(request: pytest.FixtureRequest) -> tuple[WorkingEdge, np.ndarray]:
    plant = PLANTS[request.param]
    return plant, with_hand(plant)


def test_tsypkin_is_the_least_real_part(known: tuple[WorkingEdge, np.ndarray]) -> None:
    plant, values = known
    at = int(np.argmin(values.real))
    body = {"inertia": plant.inertia, "damping": plant.damping, "stiffness": plant.hand_stiffness}
    delay = plant.transport_s / plant.period_s
    found = minimize_scalar(
        lambda omega: response(body, plant.period_s, delay, np.array([omega])).real[0],
        bounds=(OMEGAS[max(at - 1, 0)], OMEGAS[min(at + 1, len(OMEGAS) - 1)]),
        method="bounded",
        options={"xatol": 1e-9},
    )
    assert word("tsypkin", plant).stiffness == pytest.approx(-1.0 / found.fun, rel=1e-6)


def multiplied(values: np.ndarray, stiffness: float, shifts: range) -> bool:
    """Whether Re[(1/K + H)(1 - sum of r_p e^jpw)] > 0 with some r_p >= 0 of a sum up to 1: a linear program."""
    line = 1.0 / stiffness + values
    rows = np.array([(line * np.exp(1j * p * OMEGAS)).real for p in shifts]).T
    size = np.abs(line)
    weights = [*np.zeros(len(shifts)), -1.0]  # the margin is to be large
    limits = np.hstack([rows / size[:, None], np.ones((len(OMEGAS), 1))])
    limits = np.vstack([limits, [*np.ones(len(shifts)), 0.0]])
    found = linprog(weights, A_ub=limits, b_ub=[*(line.real / size), 1.0], bounds=[(0, 1)] * len(shifts) + [(None, 1)])
    return bool(found.x[-1] > 0.0)


def test_tsai_and_colgate_s_limit_is_within_what_all_shifts_together_allow(
    known: tuple[WorkingEdge, np.ndarray],
) -> None:
    """And one shift alone satisfies it just below the limit, none just above: tried on a grid of shifts and weights."""
    plant, values = known
    limit = word("tsai_colgate", plant).stiffness
    assert limit >= word("tsypkin", plant).stiffness
    shifts = [sign * p for p in range(1, 9) for sign in (1, -1)]
    assert multiplied(values, 0.999 * limit, shifts)

    def one_shift(stiffness: float) -> bool:
        line = 1.0 / stiffness + values
        return any(
            bool(((line * (1.0 - r * np.exp(1j * p * OMEGAS))).real > 0.0).all())
            for p in shifts
            for r in np.concatenate([np.linspace(0.0, 0.99, 100), 1.0 - np.geomspace(1e-9, 1e-2, 30)])
        )

    assert one_shift(0.98 * limit)
    assert not one_shift(1.001 * limit)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["tsypkin", "tsai_colgate"])
@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_where_no_oscillation_is_promised_the_loop_deep_in_the_wall_is_stable(name: str, plant: WorkingEdge) -> None:
    """There it is linear, with roots that Jury's table judges."""
    fraction = sampled_plant(
        inertia=plant.inertia,
        damping=plant.damping,
        stiffness=plant.hand_stiffness,
        period_s=plant.period_s,
        transport_s=plant.transport_s,
    )
    for share in (0.01, 0.5, 0.9999):
        gain = share * word(name, plant).stiffness
        assert stable_by_jury(in_z(np.polyadd(fraction.whole, gain * fraction.over)))


def shortage(plant: WorkingEdge, stiffness: float) -> float:
    """What a sampled wall lacks, N·m·s/rad: the least real part of torque over the mean velocity of the next period.

    E(z) = z^-n (K + B (1 - 1/z) / T) T / (z - 1), for a delay of n samples, by brute force.
    """
    z = np.exp(1j * OMEGAS)
    whole = round(plant.transport_s / plant.period_s)
    wall = stiffness + plant.wall_damping * (1.0 - 1.0 / z) / plant.period_s
    return float(-(wall * plant.period_s / (z - 1.0) / z**whole).real.min())


@pytest.mark.parametrize("virtual", [0.0, 5e-5])
@pytest.mark.parametrize("whole", [0, 1, 3])
def test_miller_s_limit_is_where_the_wall_lacks_what_the_damper_has(virtual: float, whole: int) -> None:
    """At the limit by the formula, which for a delay and virtual damping asks for no less than the least real part."""
    plant = edge(wall_damping=virtual, transport_s=whole * 1e-3)
    limit = word("miller", plant).stiffness
    lacking = shortage(plant, limit)
    assert lacking <= plant.damping * (1.0 + 1e-6)
    if not (virtual and whole):
        assert lacking == pytest.approx(plant.damping, rel=1e-6)


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
@pytest.mark.parametrize("virtual", [0.0, 0.3, 2.0])
def test_miller_s_limit_solves_the_condition(plant: WorkingEdge, virtual: float) -> None:
    plant = plant._replace(wall_damping=virtual * plant.damping)
    limit = word("miller", plant).stiffness
    if virtual > 1.0:
        assert limit == 0.0
        return
    for factor in (1.0 - 1e-9, 1.0 + 1e-9):
        at = plant._replace(wall_stiffness=factor * limit)
        assert word("miller", at).holds == (factor < 1.0)
        assert (needed_damping(at, virtual=abs(at.wall_damping)) < at.damping) == (factor < 1.0)


def characteristic(plant: WorkingEdge, *, stiffness: float, virtual: float) -> np.ndarray:
    """Of the knob alone with K and B, in z; its plant by the closed form for a damper and no spring."""
    inertia, damping, period = 0.9 * plant.inertia, 0.6 * plant.damping, plant.period_s
    fade = np.exp(-damping * period / inertia)
    slow = inertia / damping
    # x: (T - slow (1 - fade)) / damping at once, and the rest with the next sample.
    first = (period - slow * (1.0 - fade)) / damping
    second = (slow * (1.0 - fade) - period * fade) / damping
    over, under = np.array([first, second]), np.poly([1.0, fade])
    controller = np.array([stiffness + virtual / period, -virtual / period])
    whole = round(plant.transport_s / plant.period_s)
    return np.polyadd(np.polymul(under, [1.0, *[0.0] * (whole + 1)]), np.polymul(over, controller))


@pytest.mark.one_in(5)
@pytest.mark.parametrize("whole", [0, 1, 20])
@pytest.mark.parametrize("virtual", [0.0, 1e-5, 3e-4])
@pytest.mark.parametrize("name", [name for name in PLANTS if name != "delayed"])
def test_love_and_book_s_bounds_are_those_of_jury_s_table(name: str, virtual: float, whole: int) -> None:
    plant = PLANTS[name]
    plant = plant._replace(wall_damping=virtual * plant.damping / 3.45e-4, transport_s=whole * plant.period_s)
    found = word("love_book", plant)
    limit, held = found.stiffness, plant.wall_damping
    stiffness = plant.wall_stiffness
    if limit == 0.0:  # none is stable
        tried = [
            characteristic(plant, stiffness=share * stiffness, virtual=held) for share in np.geomspace(1e-5, 10, 40)
        ]
        assert not any(stable_by_jury(one) for one in tried)
        assert not found.holds
    else:
        assert stable_by_jury(characteristic(plant, stiffness=0.999 * limit, virtual=held))
        assert not stable_by_jury(characteristic(plant, stiffness=1.001 * limit, virtual=held))
    assert found.holds == stable_by_jury(characteristic(plant, stiffness=stiffness, virtual=held))
    least, most = found.least_damping, found.most_damping
    if most is not None:
        assert stable_by_jury(characteristic(plant, stiffness=stiffness, virtual=0.999 * most))
        assert not stable_by_jury(characteristic(plant, stiffness=stiffness, virtual=1.001 * most))
        if least:
            assert stable_by_jury(characteristic(plant, stiffness=stiffness, virtual=1.001 * least))
            assert not stable_by_jury(characteristic(plant, stiffness=stiffness, virtual=0.999 * least))


def test_a_stiff_wall_needs_a_least_virtual_damping() -> None:
    """The dissertation: Love and Book found a lower and an upper bound of the damping."""
    found = word("love_book", edge(wall_stiffness=0.8))
    assert not found.holds
    assert 0.0 < found.least_damping < found.most_damping


@pytest.mark.parametrize("virtual", [0.0, 0.1, 1.0, 5.0])
def test_llewellyn_s_limit_is_where_a_lossless_environment_makes_the_port_active(virtual: float) -> None:
    """Z_in = h11 - h12 h21 / (h22 + Y) of every susceptance Y = jy of the environment has no negative real part."""
    plant = edge(wall_damping=virtual * 0.6 * 3.45e-4)
    found = word("llewellyn", plant)
    spare, period = 0.6 * plant.damping, plant.period_s
    if virtual == 0.0:
        assert found.stiffness == pytest.approx(8.0 * spare / period)
    z = np.exp(1j * np.linspace(1e-3, pi - 1e-3, 200))[:, None]
    susceptance = np.tan(np.linspace(-0.5 * pi + 1e-4, 0.5 * pi - 1e-4, 2001))[None, :]
    for factor in (0.99, 1.01):
        coupling = plant.wall_damping + factor * found.stiffness * period * z / (z - 1.0)
        impedance = spare + (z + 1.0) / (2.0 * z) / (1.0 / coupling + 1j * susceptance / spare)
        assert bool((impedance.real > -1e-3 * spare * 1e-3).all()) == (factor < 1.0)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", CRITERIA)
@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_limits_scale_with_torque_and_with_time(name: str, plant: WorkingEdge) -> None:
    """Inertia, damping and stiffness times c: so is the limit. Time over c: stiffness times c^2, damping times c."""
    if name == "llewellyn":
        plant = plant._replace(transport_s=0.0)
    base = word(name, plant).stiffness
    c = 3.0
    stronger = plant._replace(
        inertia=c * plant.inertia, damping=c * plant.damping, hand_stiffness=c * plant.hand_stiffness
    )
    assert word(name, stronger).stiffness == pytest.approx(c * base, rel=1e-5)
    quicker = plant._replace(
        damping=c * plant.damping,
        hand_stiffness=c * c * plant.hand_stiffness,
        period_s=plant.period_s / c,
        transport_s=plant.transport_s / c,
    )
    assert word(name, quicker).stiffness == pytest.approx(c * c * base, rel=1e-5)


@pytest.mark.parametrize("name", CRITERIA)
def test_a_criterion_holds_below_its_limit_only(name: str) -> None:
    limit = word(name, edge()).stiffness
    for factor in (0.999, 1.001):
        assert word(name, edge(wall_stiffness=factor * limit)).holds == (factor < 1.0)


def test_what_a_criterion_does_not_know_is_said() -> None:
    assert (
        word("tsypkin", edge(wall_damping=1e-5)).reason == "the torque is no function of one angle with virtual damping"
    )
    assert word("tsai_colgate", edge(damping=0.0)).reason == "nothing damps the knob"
    assert word("tsypkin", edge(hand_stiffness=0.0)).reason == "nothing holds the knob outside the wall"
    assert word("miller", edge(coulomb_torque=1e-4)).reason == "the criterion knows no friction"
    assert word("llewellyn", edge(transport_s=1e-4)).reason == "the two-port knows no delay beyond the hold"
    assert word("love_book", edge(transport_s=21e-3)).reason == "it is computed for delays of up to 20 samples"
    assert word("llewellyn", edge(wall_damping=-1e-4)).holds is False
    assert word("llewellyn", edge(), knob_share=0.0).stiffness == 0.0
    assert word("miller", edge(damping=0.0)).holds is False
    assert word("love_book", edge(damping=0.0)).holds is False
    for name in CRITERIA:
        assert word(name, edge(wall_stiffness=0.0)).holds


def knob(rounding: str, offset: float, push: float | None) -> Scene:
    bias = None if push is None else Bias(torque=push)
    encoder = Encoder(rounding=rounding, offset_counts=offset)
    return Scene(knob=Knob(1.9e-6), wall=Wall(0.27), hand=Hand(3e-7, 3.45e-4, 0.04), bias=bias, encoder=encoder)


@pytest.mark.parametrize(
    ("rounding", "offset", "push", "expected"),
    [
        ("floor", 0.0, None, inf),
        ("nearest", 0.0, None, 2.0),
        ("nearest", 0.0, 1e-3, inf),
        ("nearest", 0.25, None, 3.0),
        ("nearest", 0.5, None, inf),
        ("ceil", 0.0, None, 1.0),
        ("truncate", 0.5, 0.0, 1.0),
    ],
)
def test_the_steepest_line_to_the_counts(rounding: str, offset: float, push: float | None, expected: float) -> None:
    scene = knob(rounding, offset, push)
    found = case_of(scene, working_edge(scene, {"sample_rate_hz": 1000.0, "counts_per_rev": 1024}))
    assert found.steepest == expected
    limits = {name: CRITERIA[name](found) for name in ("tsypkin", "tsai_colgate", "miller", "love_book", "llewellyn")}
    assert limits["tsypkin"].quantised == pytest.approx(limits["tsypkin"].stiffness / expected)
    assert limits["tsai_colgate"].quantised == limits["miller"].quantised == 0.0
    assert limits["love_book"].quantised is limits["llewellyn"].quantised is None
