"""What a sweep says of touch and hearing, against the motion sampled densely and judged by hand."""

import json
from math import log10, nan, pi, sqrt
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.errors import SpecError
from hknob_cli.measure.orbit import Harmonics
from hknob_cli.perception.hearing import hearing_threshold
from hknob_cli.perception.level import published
from hknob_cli.perception.touch import detection_threshold
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.generated import json_schema
from hknob_cli.specs.perception import Perceive
from hknob_cli.stages.sweep.perceived import Perceived, cell_row, orbit_row, perceive
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.tables import SweepTables
from tests.conftest import SPEC, loaded

BLOCK = "perceive: {knob_radius: 8.9 mm}\n"
GAIN = "perceive: {knob_radius: 8.9 mm, sound_gain: 0.02 Pa/(rad/s)}\n"
HOW = Perceive(8.9e-3, sound_gain=0.02)
PARTS = 64  # of a hold


def sweep(text: str) -> SweepTables:
    return SweepStage(loaded(text)).run()


def rows(table: pa.Table) -> list[dict[str, Any]]:
    return table.to_pylist()


@pytest.fixture(scope="module")
def gained() -> SweepTables:
    return sweep(SPEC + GAIN)


def sampled_motion(orbit: int) -> tuple[np.ndarray, float]:
    """Angle (rad) at 64 times in each hold of an orbit of the small spec, and the length of its period (s)."""
    plan = loaded(SPEC)
    knob = sample_knob(plan.scene, sample_rate_hz=1000.0, counts_per_rev=1024)
    engine = Engine()
    found = engine.search(knob.loop, x=knob.position(0.02), v=0.0, phases=8, delay_line=0, max_samples=None)
    one = [a for a in found.attractors if a.outcome is Outcome.CYCLE][orbit]
    xs, vs, _, drive = engine.trace(knob.loop, one)
    angle = []
    for x, v, u in zip(xs, vs, drive, strict=False):
        y = u - knob.loop.beta * x
        for part in range(PARTS):
            s, g, _ = hold_coefficients(knob.loop.alpha, knob.loop.beta, part / PARTS)
            angle.append(knob.angle_rad(x + (s * v + g * y)))
    return np.array(angle), one.period * knob.period_s


def test_levels_of_the_best_harmonics_by_a_fourier_transform_of_the_motion(gained: SweepTables) -> None:
    """Aliases are below 2e-6: amplitudes fall as the cube of the frequency, and the first is 64 times n away."""
    for orbit, row in enumerate(rows(gained.orbits)):
        angle, seconds = sampled_motion(orbit)
        amplitude = 2.0 * np.abs(np.fft.rfft(angle)) / len(angle)
        hertz = np.arange(len(amplitude)) / seconds
        felt = [
            (20.0 * log10(8.9e-3 * a / float(detection_threshold(f))), f)
            for a, f in zip(amplitude, hertz, strict=True)
            if 10.0 <= f <= 320.0
        ]
        assert (row["touch_db"], row["touch_hz"]) == pytest.approx(max(felt), abs=1e-4)
        pressure = 0.02 * 2.0 * pi * hertz * amplitude / sqrt(2.0)
        at = int(np.argmin(np.abs(hertz - row["hearing_hz"])))
        assert hertz[at] == pytest.approx(row["hearing_hz"])
        level = 20.0 * log10(pressure[at] / 20e-6)
        assert row["hearing_db"] == pytest.approx(level - float(hearing_threshold(hertz[at])), abs=1e-3)


def test_columns_have_units_and_meanings_and_only_what_was_asked_for(gained: SweepTables) -> None:
    plain = sweep(SPEC)
    added = [name for name in gained.cells.column_names if name not in plain.cells.column_names]
    assert added == [
        "touch_db",
        "touch_hz",
        "felt_fraction",
        "hearing_db",
        "hearing_hz",
        "hearing_phon",
        "heard_fraction",
        "torque_step_db",
    ]
    without = sweep(SPEC + BLOCK)
    assert [name for name in without.orbits.column_names if name not in plain.orbits.column_names] == [
        "touch_db",
        "touch_hz",
        "hearing_relative_db",
        "hearing_hz",
        "torque_step_db",
    ]
    for table in (gained.cells, gained.orbits, without.cells, without.orbits):
        for field in table.schema:
            assert field.metadata[b"meaning"]
            assert b"unit" in field.metadata
    # The rest is what it is without.
    assert gained.cells.select(plain.cells.column_names) == plain.cells


def test_a_cell_has_its_most_noticeable_orbit(gained: SweepTables) -> None:
    (cell,), orbits = rows(gained.cells), rows(gained.orbits)
    assert len(orbits) > 1
    assert cell["touch_db"] == max(row["touch_db"] for row in orbits)
    assert cell["hearing_db"] == max(row["hearing_db"] for row in orbits)
    assert cell["felt_fraction"] == 1.0


def test_a_table_of_one_gain_is_that_gain(gained: SweepTables) -> None:
    table = sweep(SPEC + "perceive: {knob_radius: 8.9 mm, sound_response: [[1 Hz, 0.02], [1 MHz, 0.02]]}\n")
    assert table.cells.column_names == gained.cells.column_names
    for ours, theirs in zip(rows(table.orbits), rows(gained.orbits), strict=True):
        assert ours["hearing_db"] == pytest.approx(theirs["hearing_db"], abs=1e-9)
        assert ours["hearing_hz"] == theirs["hearing_hz"]


def test_noise_at_the_ear_hides_the_sound_by_hand(gained: SweepTables) -> None:
    """60 dB of pink noise: what the critical band about a tone has of its ten octaves, less the masking index."""
    noisy = sweep(SPEC + GAIN.replace("sound_gain", "hearing: {background: {level_db: 60}}, sound_gain"))
    assert noisy.cells.column_names == gained.cells.column_names
    for one, quiet in zip(rows(noisy.orbits), rows(gained.orbits), strict=True):
        assert one["touch_db"] == quiet["touch_db"]
        assert one["hearing_phon"] is None
        f = one["hearing_hz"]
        width = 25.0 + 75.0 * (1.0 + 1.4e-6 * f * f) ** 0.69
        low = 0.5 * (sqrt(width**2 + 4.0 * f * f) - width)
        band = 60.0 + 10.0 * log10(np.log((low + width) / low) / np.log(1000.0))
        masked = band - 2.0 - log10(1.0 + (f / 502.0) ** 2.5)
        assert masked > hearing_threshold(f)
        assert one["hearing_db"] < quiet["hearing_db"]
        if f == quiet["hearing_hz"]:
            assert quiet["hearing_db"] - one["hearing_db"] == pytest.approx(masked - float(hearing_threshold(f)))


def test_relative_sound_is_sound_less_the_gain() -> None:
    """0 dB re 1 rad/s peak is 20 log10(gain / (sqrt(2) 20 uPa)) dB SPL."""
    (loud,), (relative,) = rows(sweep(SPEC + GAIN).cells), rows(sweep(SPEC + BLOCK).cells)
    offset = 20.0 * log10(0.02 / (sqrt(2.0) * 20e-6))
    assert loud["hearing_db"] - relative["hearing_relative_db"] == pytest.approx(offset)
    assert loud["hearing_hz"] == relative["hearing_hz"]


def test_outside_what_is_published_there_is_no_value_unless_extrapolation_is_asked_for() -> None:
    high = lines(400.0, 1e-4)
    assert np.isnan(perceive(high, HOW).touch_db)
    assert perceive(high, HOW._replace(extrapolate=True)).touch_hz == 400.0
    (fine,) = rows(sweep(SPEC + BLOCK).cells)
    assert fine["torque_step_db"] is None
    (more,) = rows(sweep(SPEC + "perceive: {knob_radius: 8.9 mm, extrapolate: true}\n").cells)
    # K Δθ = 0.27 * 2π / 1024 over 0.111 mN m.
    assert more["torque_step_db"] == pytest.approx(20.0 * log10(0.27 * 2.0 * pi / 1024 / 1.11e-4))
    (coarse,) = rows(sweep(SPEC.replace("1024", "128") + BLOCK).cells)
    assert coarse["torque_step_db"] == pytest.approx(20.0 * log10(0.27 * 2.0 * pi / 128 / 1.11e-4))


def lines(hertz: float, angle: float) -> Harmonics:
    """One sinusoid, as a harmonic of a period of a tenth of a second."""
    frequency = 10.0 * np.arange(1, 1251)
    return Harmonics(frequency, np.where(frequency == hertz, angle, 0.0).astype(complex))


def test_loudness_is_of_iso_226_only_where_it_is_specified() -> None:
    """1 kHz at 60 dB SPL is 60 phon; at 10 dB it is audible and below 20 phon; at 0 dB it is not audible."""
    for level, phon in ((60.0, 60.0), (10.0, None), (0.0, None)):
        speed = sqrt(2.0) * 20e-6 * 10.0 ** (level / 20.0) / 0.02
        one = perceive(lines(1000.0, speed / (2.0 * pi * 1000.0)), HOW)
        assert one.hearing_db == pytest.approx(level - 2.4)
        assert orbit_row(one, HOW, nan)["hearing_phon"] == (None if phon is None else pytest.approx(phon))
        beyond = perceive(lines(1000.0, speed / (2.0 * pi * 1000.0)), HOW._replace(extrapolate=True))
        assert beyond.hearing_phon == pytest.approx(level) if level > 0.0 else np.isnan(beyond.hearing_phon)


def test_ten_times_the_radius_is_20_db() -> None:
    near, far = (perceive(lines(100.0, 1e-4), HOW._replace(knob_radius=radius)) for radius in (1e-3, 1e-2))
    assert far.touch_db - near.touch_db == pytest.approx(20.0)


def test_a_period_whose_highest_harmonics_are_missing_is_not_judged_by_the_others() -> None:
    whole = lines(100.0, 1e-3)
    for count, known in ((1250, (True, True)), (500, (True, False)), (31, (False, False))):
        one = perceive(Harmonics(whole.frequency_hz[:count], whole.angle_rad[:count]), HOW)
        assert (np.isfinite(one.touch_db), np.isfinite(one.hearing_db)) == known


def test_a_gain_may_change_with_frequency() -> None:
    """Twice the gain for twice the frequency, from 0.01 at 100 Hz: a harmonic of 300 Hz has 0.03, 9.5 dB more."""
    rising = Perceive(8.9e-3, sound_response=((100.0, 0.01), (400.0, 0.04)))
    for hertz, gain in ((100.0, 0.01), (300.0, 0.03), (400.0, 0.04)):
        by_one = perceive(lines(hertz, 1e-4), Perceive(8.9e-3, sound_gain=gain))
        by_table = perceive(lines(hertz, 1e-4), rising)
        assert by_table.hearing_db == pytest.approx(by_one.hearing_db, abs=1e-9)
        assert by_table.touch_db == pytest.approx(by_one.touch_db, nan_ok=True)
    flat = Perceive(8.9e-3, sound_response=((1.0, 0.02), (20000.0, 0.02)))
    assert perceive(lines(1000.0, 1e-6), flat)[2:4] == pytest.approx(perceive(lines(1000.0, 1e-6), HOW)[2:4])


def test_where_the_gain_was_not_measured_there_is_no_level() -> None:
    """Of a loud harmonic outside the table and a faint one inside, the faint one is judged, unless asked to go on."""
    both = lines(1000.0, 1e-3)
    both.angle_rad[19] = 1e-6  # at 200 Hz
    table = Perceive(8.9e-3, sound_response=((100.0, 0.02), (500.0, 0.02)))
    assert perceive(both, table).hearing_hz == 200.0
    assert perceive(both, table._replace(extrapolate=True)).hearing_hz == 1000.0
    none = perceive(lines(1000.0, 1e-3), table)
    assert np.isnan(none.hearing_db)
    assert np.isnan(none.hearing_phon)


def test_without_a_cycle_there_is_no_level() -> None:
    row = cell_row([Perceived(), Perceived()], [0.5, 0.5], HOW, nan)
    assert row["touch_db"] is None
    assert row["hearing_db"] is None
    assert row["felt_fraction"] == row["heard_fraction"] == 0.0
    assert np.isnan(perceive(Harmonics(np.zeros(0), np.zeros(0, complex)), HOW).touch_db)


def test_fractions_are_of_the_trials_whose_cycle_is_above_threshold() -> None:
    felt, unfelt = Perceived(5.0, 100.0, 3.0, 200.0), Perceived(-5.0, 100.0, -3.0, 200.0)
    row = cell_row([unfelt, felt, Perceived()], [0.5, 0.25, 0.25], HOW, nan)
    assert (row["touch_db"], row["felt_fraction"], row["heard_fraction"]) == (5.0, 0.25, 0.25)


def test_a_knob_at_rest_and_a_wall_without_stiffness_have_no_levels() -> None:
    still = sweep(SPEC.replace("{stiffness: 0.27}", "{stiffness: 0.0}").replace("1024", "128") + GAIN)
    assert [row["outcome"] for row in rows(still.orbits)] == ["rest"]
    (cell,) = rows(still.cells)
    assert cell["touch_db"] is cell["hearing_db"] is cell["torque_step_db"] is None
    assert cell["felt_fraction"] == cell["heard_fraction"] == 0.0


def test_a_knob_that_nothing_damps_has_no_cycle_to_feel() -> None:
    """A sweep of such a scene takes the growth of its energy unasked; an axis may have it in some cells only."""
    ball = SPEC.replace("damping: 3.45e-4, stiffness: 0.04", "damping: 0.0, stiffness: 0.0")
    (cell,) = rows(sweep(ball + BLOCK).cells)
    assert cell["growth_j_per_s2"] > 0.0
    assert cell["touch_db"] is None
    axis = ball.replace("  counts_per_rev:", "  hand.damping: [0.0, 1.0e-3]\n  counts_per_rev:")
    assert len(rows(sweep(axis + BLOCK).cells)) == 2


def test_beyond_the_plain_loop_and_for_people() -> None:
    rubbing = SPEC.replace("{inertia: 1.9e-6}", "{inertia: 1.9e-6, coulomb_torque: 6.0e-5}") + BLOCK
    assert rows(sweep(rubbing).cells)[0]["touch_db"] > 0.0
    text = SPEC.replace("  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n", "")
    people = sweep(text + "population: {table: 1, grip_n: 0.71, people: 3, seed: 1}\n" + BLOCK)
    assert [row["person"] for row in rows(people.cells)] == [1, 2, 3]
    assert all(row["touch_db"] > 0.0 for row in rows(people.cells))


def test_without_an_encoder_there_is_no_torque_step() -> None:
    analog = SPEC.replace("  counts_per_rev: [1024]\n", "").replace("scene:\n", "scene:\n  encoder: none\n")
    found = sweep(analog.replace("{stiffness: 0.27}", "{stiffness: 3.0}") + BLOCK)
    assert "torque_step_db" not in found.cells.column_names
    assert "touch_db" in found.orbits.column_names


@pytest.mark.parametrize(
    ("block", "fault"),
    [
        ("perceive: {}\n", "perceive.knob_radius: missing, and required"),
        ("perceive: {knob_radius: 0}\n", "perceive.knob_radius: must be > 0"),
        ("perceive: {knob_radius: 8.9 g}\n", "perceive.knob_radius: '8.9 g' is in gram"),
        ("perceive: {knob_radius: 8.9 mm, touch: {thresholds: pen}}\n", "perceive.touch.thresholds"),
        ("perceive: {knob_radius: 8.9 mm, sound_gain: 0.02 Pa}\n", "perceive.sound_gain: '0.02 Pa' is in pascal"),
        ("perceive: {knob_radius: 8.9 mm, sound_gian: 0.02}\n", "did you mean 'sound_gain'"),
        ("perceive: {knob_radius: 8.9 mm, hearing: {edition: 1987}}\n", "perceive.hearing.edition"),
        ("perceive: {knob_radius: 8.9 mm, sound_response: [[100, 0.02]]}\n", "must have two [frequency, gain] or more"),
        ("perceive: {knob_radius: 8.9 mm, sound_response: [[200, 0.02], [100, 0.02]]}\n", "frequencies must increase"),
        ("perceive: {knob_radius: 8.9 mm, sound_response: [[100, 0], [200, 0.02]]}\n", "must be > 0"),
        (
            "perceive: {knob_radius: 8.9 mm, hearing: {background: {level_db: 40}}}\n",
            "hearing.background: must be absent without sound_gain or sound_response",
        ),
        (
            "perceive: {knob_radius: 8.9 mm, sound_gain: 1, hearing: {background: {level_db: 40, spectrum: red}}}\n",
            "perceive.hearing.background.spectrum",
        ),
        (
            "perceive: {knob_radius: 8.9 mm, sound_gain: 0.02, hearing: {background: {level_db: 400}}}\n",
            "perceive.hearing.background.level_db: must be <= 140",
        ),
        (
            "perceive: {knob_radius: 8.9 mm, sound_gain: 0.02, sound_response: [[100, 0.02], [200, 0.02]]}\n",
            "sound_response: must be absent where sound_gain is given",
        ),
    ],
)
def test_faults_of_the_block(block: str, fault: str) -> None:
    with pytest.raises(SpecError) as error:
        loaded(SPEC + block)
    assert fault in str(error.value)


def test_what_has_no_proven_cycle_is_refused() -> None:
    text = SPEC.replace("  sample_rate_hz: [1000]\n", "").replace("scene:\n", "scene:\n  sampling: continuous\n")
    with pytest.raises(SpecError, match="perceive: must be absent where sampling is continuous"):
        loaded(text + BLOCK)
    ball = SPEC.replace("  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n", "")
    with pytest.raises(SpecError, match="perceive: must be absent where 'growth' is given"):
        loaded(ball + "growth: {duration: 0.1}\n" + BLOCK)


def test_the_spec_knows_the_published_sets_and_editions() -> None:
    schema = json.dumps(json_schema("sweep")["$defs"])
    known = json_schema("sweep")["$defs"]
    assert known["TouchSpec"]["properties"]["thresholds"]["enum"] == list(published("touch")["thresholds"])
    assert sorted(known["HearingSpec"]["properties"]["edition"]["enum"]) == sorted(published("hearing")["editions"])
    assert "PerceiveSpec" in schema
