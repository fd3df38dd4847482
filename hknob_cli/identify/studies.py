"""How far off each estimator is, and why: one nuisance at a time, and a finger that the model leaves out.

Noise of the angle (Section 4.4's implicit regularization), Coulomb friction and the amplifier's lag (Appendix A.2) that
the model leaves out, the encoder's counts, and the smoothing that differentiation needs, each from next to nothing
upwards, the others at rest.

Section 4.4.1 as a curve: what a second-order fit takes for the inertia of finger, fingerpad and knob.

As the finger gets stiffer than its pad it hides behind it, and the fitted inertia falls to the knob's own. The series
of finger and pad stays what it is, so only the split changes along the curve. With K1/K2 = B1/B2 = r the finger moves
1/(1 + r) of what the knob does, and adds J1/(1 + r)^2 to it.
"""

from collections.abc import Callable, Mapping, Sequence
from math import nan, pi
from typing import NamedTuple

import numpy as np

from hknob_cli.apparatus.people import mean_hand
from hknob_cli.errors import UsageError
from hknob_cli.identify.fit import Fit
from hknob_cli.identify.fourth_order import FINGER_INERTIA, hold_matrices, network, respond_fourth, split
from hknob_cli.identify.least_squares import least_squares, least_squares_friction
from hknob_cli.identify.motion import Motion, differentiate, smooth
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.second_order import Plant, respond
from hknob_cli.recordings.trial import Array

GRIPS = (0.71, 14.2)  # N: lightest and firmest of the tables
COUNTS, PULSE_S, PEAK_RAD, DT_S, TRIALS = 640_000, 0.02, 0.09, 1e-4, 3
NUISANCES: dict[str, tuple[float, ...]] = {
    "noise_rad": (0.0, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3),
    "coulomb_nm": (0.0, 1e-4, 3e-4, 5.6e-4, 1e-3),
    "lag_s": (0.0, 2e-5, 5e-5, 1e-4, 2e-4),
    "counts_per_rev": (float(COUNTS), 65536.0, 16384.0, 8192.0, 4096.0),
    "decimation": (1.0, 2.0, 5.0, 10.0, 20.0, 40.0),
}
UNITS = {"noise_rad": "rad", "coulomb_nm": "N*m", "lag_s": "s", "counts_per_rev": "1/rev", "decimation": "1"}
DECIMATION, QUIET_RAD = 10, 1e-5  # smoothing while noise or friction varies; noise while smoothing does
BEFORE, AFTER, MARGIN = 20, 300, 400  # samples kept before and after the onset, and taken up by the filter's ends

FASTEST = 1e9  # rate of the finger times the interval, beyond which rounding costs the fitted damping more than 1e-6
PULSE_S, WINDOW_S, DT_S = 0.02, 0.03, 1e-4  # length of the pulse, of the record, and between samples
RATIOS = tuple(float(ratio) for ratio in np.geomspace(1.0, 1000.0, 13))


class Bias(NamedTuple):
    """An estimate's mean error and standard deviation, in per cent of the ``truth`` (SI; of friction: its level)."""

    grip_n: float
    nuisance: str
    level: float
    estimator: str
    parameter: str
    truth: float
    bias_percent: float
    std_percent: float


def bias_study(
    repeats: int = 50,
    *,
    table: int = 1,
    grips_n: Sequence[float] = GRIPS,
    nuisances: Mapping[str, Sequence[float]] | None = None,
    seed: int = 1,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> list[Bias]:
    """Biases by Monte Carlo, ``repeats`` conditions each of three averaged trials of 10 kHz and 640,000 counts.

    ``table``, ``grips_n``: whose mean hands are true. ``nuisances``: levels by name, of `NUISANCES` (``lag_s``: time
    constant; ``counts_per_rev`` 0: no counts). The least squares get the angle smoothed and differentiated; output
    error gets it as averaged. ``progress`` is told of the conditions done, and of how many. Raises `UsageError` for a
    grip that is not in the table.
    """
    chosen = NUISANCES if nuisances is None else nuisances
    jobs = [(grip_n, name, level) for grip_n in grips_n for name, levels in chosen.items() for level in levels]
    found = []
    for done, (grip_n, nuisance, level) in enumerate(jobs):
        plant = Plant(*mean_hand(table, grip_n))

        def tick(repeat: int, before: int = done * repeats) -> None:
            progress(before + repeat, len(jobs) * repeats)

        found += _at(grip_n, plant, nuisance, float(level), repeats, np.random.default_rng(seed), tick)
    return found


def pulsed(
    plant: Plant, noise_rad: float, rng: np.random.Generator, *, lag_s: float = 0.0, counts_per_rev: float = COUNTS
) -> Motion:
    """Mean of three trials of a 20 ms pulse to 0.09 rad, through noise and encoder; margins, no derivatives."""
    onset = BEFORE + MARGIN
    torque = np.zeros(onset + AFTER + MARGIN + 1)
    torque[onset : onset + round(PULSE_S / DT_S)] = 1.0
    push = PEAK_RAD / float(np.max(respond(plant._replace(coulomb=0.0), torque, DT_S, lag_s=lag_s)))
    if plant.coulomb:  # the push that reaches the angle in spite of friction, by fixed-point steps
        for _ in range(8):
            push *= PEAK_RAD / max(float(np.max(respond(plant, torque * push, DT_S, lag_s=lag_s))), 0.1 * PEAK_RAD)
    angle = respond(plant, torque * push, DT_S, lag_s=lag_s)
    step = 2.0 * pi / counts_per_rev if counts_per_rev else 0.0
    total = np.zeros_like(angle)
    for _ in range(TRIALS):
        seen = angle + rng.uniform(0.0, step) + rng.normal(0.0, 1.0, len(angle)) * noise_rad
        read = np.floor(seen / step) * step if step else seen
        total += read - np.mean(read[:onset])
    noise = (noise_rad**2 / TRIALS + step**2 / (12.0 * TRIALS)) ** 0.5
    return Motion(DT_S, torque * push, total / TRIALS, noise_rad=noise or None, averaged=TRIALS)


def differentiated(motion: Motion, factor: int) -> Motion:
    """Motion with angle and velocity smoothed by filtered decimation, and the margins cut."""
    angle = smooth(motion.angle_rad, factor)
    velocity = smooth(differentiate(angle, motion.dt_s), factor)
    acceleration = differentiate(velocity, motion.dt_s)
    kept = slice(MARGIN, -MARGIN)
    return motion._replace(
        torque_nm=motion.torque_nm[kept],
        angle_rad=angle[kept],
        velocity_rad_s=velocity[kept],
        acceleration_rad_s2=acceleration[kept],
    )


def _at(
    grip_n: float,
    plant: Plant,
    nuisance: str,
    level: float,
    repeats: int,
    rng: np.random.Generator,
    tick: Callable[[int], None],
) -> list[Bias]:
    noise = {"noise_rad": level, "decimation": QUIET_RAD}.get(nuisance, 0.0)
    factor = int(level) if nuisance == "decimation" else DECIMATION
    lag_s, counts = (level if nuisance == name else rest for name, rest in (("lag_s", 0.0), ("counts_per_rev", COUNTS)))
    true = plant._replace(coulomb=level if nuisance == "coulomb_nm" else 0.0)
    kept = slice(MARGIN, -MARGIN)
    errors: dict[tuple[str, str], list[float]] = {}
    for repeat in range(repeats):
        tick(repeat)
        raw = pulsed(true, noise, rng, lag_s=lag_s, counts_per_rev=counts)
        cut = raw._replace(torque_nm=raw.torque_nm[kept], angle_rad=raw.angle_rad[kept])
        smoothed = differentiated(raw, factor)
        jobs: tuple[tuple[Callable[..., Fit], Motion, dict[str, bool]], ...] = (
            (least_squares, smoothed, {}),
            (least_squares_friction, smoothed, {}),
            (output_error, cut, {}),
            (output_error, cut, {"fit_coulomb": True}),
        )
        for estimator, motion, options in jobs:
            fit = estimator(motion, **options)
            for name, one in fit.parameters.items():
                truth = getattr(true, name)
                error = 100.0 * (one.value / truth - 1.0) if truth else nan
                errors.setdefault((fit.estimator, name), []).append(error)
    tick(repeats)
    rows = []
    for (estimator_name, parameter), values in errors.items():
        if np.all(np.isfinite(values)):
            std = float(np.std(values, ddof=1)) if repeats > 1 else nan
            mean, truth = float(np.mean(values)), getattr(true, parameter)
            rows.append(Bias(grip_n, nuisance, level, estimator_name, parameter, truth, mean, std))
    return rows


class Hidden(NamedTuple):
    """Fitted second-order values at a ratio K1/K2 = B1/B2, and the share of the angle's variance they explain."""

    ratio: float
    estimator: str
    inertia: float
    damping: float
    stiffness: float
    vaf: float


def hidden_inertia(
    damping: float,
    stiffness: float,
    *,
    inertia: float,
    finger_inertia: float = FINGER_INERTIA,
    ratios: Sequence[float] = RATIOS,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> list[Hidden]:
    """Second-order fits of noiseless pulse responses of the fourth-order hand, by least squares and output error.

    ``damping``, ``stiffness``: of finger and pad in series (Table 1's at 14.2 N in the dissertation's figure);
    ``inertia`` of the knob and what turns with it, ``finger_inertia`` (kg·m²). Velocity and acceleration are the
    model's own, so that nothing but the model's order is at work. Raises `UsageError` for a finger too light to follow.
    """
    for ratio in ratios:
        if (1.0 + ratio) ** 2 / ratio * damping / finger_inertia * DT_S > FASTEST:
            raise UsageError(
                f"a finger of {finger_inertia:g} kg*m^2 at the ratio {ratio:g} is too fast to be followed; "
                "make it heavier, or the ratio nearer to 1"
            )
    torque = np.zeros(round(WINDOW_S / DT_S) + 1)
    torque[: round(PULSE_S / DT_S)] = 1.0
    found = []
    for done, ratio in enumerate(ratios):
        progress(done, len(ratios))
        parts = {"inertia": inertia, "finger_inertia": finger_inertia, **split(damping, stiffness, ratio)}
        torque_nm = torque * (0.08 / float(np.max(respond_fourth(parts, torque, DT_S))))
        motion = _motion(parts, torque_nm)
        for fit in (least_squares(motion), output_error(motion)):
            whole, loss, spring = (fit.parameters[name].value for name in ("inertia", "damping", "stiffness"))
            found.append(Hidden(ratio, fit.estimator, whole, loss, spring, fit.vaf))
    return found


def _motion(parts: dict[str, float], torque_nm: Array) -> Motion:
    matrix, push = network(parts)
    move, added = (one[0] for one in hold_matrices(matrix, push, DT_S))
    states = np.zeros((len(torque_nm), 4))
    for i, torque in enumerate(torque_nm[:-1]):
        states[i + 1] = move @ states[i] + added * torque
    rates = states @ matrix.T + np.outer(torque_nm, push)
    return Motion(DT_S, torque_nm, states[:, 0].copy(), states[:, 1].copy(), rates[:, 1].copy())
