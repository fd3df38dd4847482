"""Each computation against values worked out by hand, from tables small enough to do so."""

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from hknob_cli import printed
from hknob_cli.errors import UsageError
from hknob_cli.identify.fourth_order import respond_fourth
from hknob_cli.page.claims.checks import compute, known
from hknob_cli.page.claims.checks.finger import network
from hknob_cli.results.result_set import ResultSet

HEAD = (
    "grip_n,inertia_kg_m2,damping_nm_s_per_rad,damping_std_nm_s_per_rad,damping_cv_percent,"
    "stiffness_nm_per_rad,damping_ratio"
)
ONE = [
    "1,4E-06,2.0E-03,1.0E-03,50.0,1.00,0.5",
    "2,3E-06,4.0E-03,1.0E-03,25.0,1.00,0.7",
    "3,3E-06,6.0E-03,1.0E-03,10.0,2.00,1.5",
]
TWO = [
    "1,4E-06,2.5E-03,1.0E-03,40.0,0.50,0.9",
    "2,5E-06,3.0E-03,1.0E-03,33.3,1.00,0.7",
    "3,3E-06,9.0E-03,1.0E-03,11.1,3.00,1.2",
]
B, K, J = "damping_nm_s_per_rad", "stiffness_nm_per_rad", "inertia_kg_m2"


@pytest.fixture(autouse=True)
def small_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "tables.yaml").touch()
    for number, rows in ((1, ONE), (3, TWO)):
        (tmp_path / f"table_{number:02d}.csv").write_text("\n".join([HEAD, *rows, ""]))
    (tmp_path / "table_07.csv").write_text("parameter,symbol,value,unit\nwall,K,0.27,N\nhand,k,0.08,N\n")
    (tmp_path / "table_08.csv").write_text("bits,a,b,mean,std\n8,1,3,2,1.4\n9,2,4,3.5,1.41\nmean,1.5,3.5,2.5,\n")
    (tmp_path / "table_09.csv").write_text("part,x,y,z\ncap,1.5,,N/A\nscrew,2.0,1.0,\nTOTALS,3.5,1.25,N/A\n")
    monkeypatch.setattr(printed, "FOLDERS", (tmp_path,))


def value(name: str, **arguments: object) -> float | None:
    return compute(name, ResultSet({}), arguments)


def test_arithmetic_binds_names_to_places_numbers_and_each_other() -> None:
    where = {"K": [7, "K", "value"], "k": [7, "k", "value"], "n": 2, "sum": "K + k"}
    assert value("arithmetic", expression="n * sum", where=where) == pytest.approx(0.70)
    with pytest.raises(UsageError, match="unknown name 'later'"):
        value("arithmetic", expression="a", where={"a": "later", "later": 1})
    with pytest.raises(UsageError, match="table 7 has no number at 'q'"):
        value("arithmetic", expression="q", where={"q": [7, "q", "value"]})


def test_steps_over_grip() -> None:
    assert value("share_of_steps", tables=[1], quantity=B, way="rises") == 1.0
    assert value("share_of_steps", tables=[1, 3], quantity=K, way="rises") == 0.75
    assert value("share_of_steps", tables=[1, 3], quantity=J, way="falls") == 0.5


def test_straightness() -> None:
    assert value("least_r_squared", tables=[1], quantities=[B]) == pytest.approx(1.0)
    # 1, 1, 2 over 1, 2, 3: correlation 1/(sqrt 2 sqrt(2/3)) = sqrt(3)/2
    assert value("least_r_squared", tables=[1], quantities=[B, K]) == pytest.approx(0.75)


def test_one_table_above_another() -> None:
    assert value("share_of_grips_above", pairs=[[1, 3]], quantity=B) == pytest.approx(2 / 3)
    assert value("share_of_grips_above", pairs=[[1, 3], [3, 1]], quantity=B) == 0.5
    assert value("share_of_grips_above", pairs=[[1, 3]], quantity=K, grips=[2]) == 0.0  # equal is not above
    # along the rim, table 3 is divided by (14.95/8.9)^2 = 2.82 as much
    assert value("share_of_grips_above", pairs=[[1, 3]], quantity=B, translational=True) == 0.0
    assert value("share_of_grips_above", pairs=[[3, 1]], quantity=B, translational=True) == 1.0


def test_differences() -> None:
    assert value("largest_difference_percent", pairs=[[1, 3]], quantity=B) == pytest.approx(50.0)
    assert value("largest_difference_percent", pairs=[[1, 3]], quantity=B, grips=[1, 2]) == pytest.approx(25.0)
    arguments = {"quantity": B, "deviation": "damping_std_nm_s_per_rad"}
    assert value("share_within_deviation", pairs=[[1, 3]], **arguments) == pytest.approx(1 / 3)


def test_extremes_and_limits() -> None:
    assert value("extreme", tables=[1, 3], quantity=J, which="largest") == 5e-6
    assert value("extreme", tables=[1, 3], quantity=B, which="least", grips=[2, 3]) == 3e-3
    assert value("share_below", tables=[1, 3], quantity="damping_ratio", limit=1) == pytest.approx(4 / 6)


def test_variations_within_rounding() -> None:
    arguments = {"quantities": {"damping_cv_percent": [B, "damping_std_nm_s_per_rad"]}}
    # 1.0/6.0 is 15.7 to 17.6 %, not 10.0
    assert value("share_of_variations", tables=[1], **arguments) == pytest.approx(2 / 3)
    assert value("share_of_variations", tables=[3], **arguments) == 1.0


def test_ratios_within_rounding() -> None:
    # 2e-3/(2 sqrt(4e-6)) = 0.5; 4e-3/(2 sqrt(3e-6)) = 1.15, not 0.7;
    # 6e-3/(2 sqrt(6e-6)) = 1.22, and 1.13 to 1.34 as J goes from 3.5e-6 to 2.5e-6, not 1.5
    assert value("share_of_ratios_of_means", tables=[1]) == pytest.approx(1 / 3)


def test_block_margins_and_totals() -> None:
    block = {"table_number": 8, "rows": [8, 9], "columns": ["a", "b"]}
    assert value("spread_over_columns", **block, what="mean") == 2.5
    assert value("spread_over_columns", **block, what="std") == pytest.approx(sqrt(5 / 3))
    assert value("largest_margin_error", **block, margin="mean", what="mean") == 0.5  # the column: 3 printed as 3.5
    deviation = value("largest_margin_error", **block, margin="std", what="std")
    assert deviation == pytest.approx(sqrt(2) - 1.4)
    assert value("largest_total_error", table_number=9, total="TOTALS") == 0.25
    assert value("largest_total_error", table_number=9, total="screw", rows=2) == 1.0
    with pytest.raises(UsageError, match="the last row read of table 9 is 'TOTALS'"):
        value("largest_total_error", table_number=9, total="SUM")


def test_share_among() -> None:
    assert value("share_among", values=[1, 2, 2, 3.1], among=[2, 3]) == 0.5
    assert value("share_among", values=[1, 2, 2, 3.1], among=[2, 3], within_percent=5) == 0.75


def test_torque_of_an_oscillation() -> None:
    # At 1/(2 pi) Hz the angular frequency is 1 rad/s: |1 - 4e-6 + 2e-3 j|
    torque = value("oscillation_torque", number=1, grip_n=1, amplitude_rad=2.0, frequency_hz=0.5 / pi)
    assert torque == pytest.approx(2.0 * sqrt((1 - 4e-6) ** 2 + 4e-6))


WHERE = {"J1": 2.0, "B1": 3.0, "K1": 5.0, "J2": 4.0, "B2": 7.0, "K2": 11.0}
EQUATION_1 = [
    ["0", "1", "0", "0"],
    ["-11/4", "-7/4", "11/4", "7/4"],
    ["0", "0", "0", "1"],
    ["11/2", "7/2", "-16/2", "-10/2"],
]


def test_network_is_equation_1_written_out() -> None:
    assert value("matrix_difference", printed=EQUATION_1, where=WHERE) == 0.0
    changed = [*EQUATION_1[:3], ["K2/J1", "B2/J1", "-(K1 + K2)/J1", "-(B1 - B2)/J1"]]
    assert value("matrix_difference", printed=changed, where=WHERE) == pytest.approx(100 * 7 / 5)
    assert value("input_difference", printed=["0", "1", "0", "0"], where=WHERE) == pytest.approx(75.0)
    assert value("input_difference", printed=["0", "1/J2", "0", "0"], where=WHERE) == 0.0


def test_springs_in_series() -> None:
    assert value("static_stiffness", where=WHERE) == pytest.approx(5 * 11 / 16)


def test_the_order_of_the_network() -> None:
    """Four states with the actuator's mass, three without, and two without the finger's."""
    assert value("network_order", where=WHERE) == 4.0
    assert value("network_order", where={**WHERE, "J2": 0}) == 3.0
    assert value("network_order", where={**WHERE, "J2": 0, "J1": 0}) == 2.0


def test_how_deep_the_knob_dips_against_the_motion_sample_by_sample() -> None:
    """By the identification's own network, whose step is exact, every 10 us."""
    hand = {"J1": 3.0e-7, "K1": 0.46, "B1": 1.173e-3, "J2": 1.98e-6, "K2": 0.46, "B2": 0.05865}
    names = {"J2": "inertia", "J1": "finger_inertia", "B1": "finger_damping", "K1": "finger_stiffness"}
    names |= {"B2": "pad_damping", "K2": "pad_stiffness"}
    angle = respond_fourth({names[key]: one for key, one in hand.items()}, np.ones(2001), 1e-5)
    falls = np.flatnonzero(np.diff(angle) < 0.0)
    rise = next(i for i in range(falls[0], 2000) if angle[i + 1] > angle[i])
    depth = 100.0 * (angle[falls[0]] - angle[rise]) / angle[falls[0]]
    assert depth > 5.0
    assert value("dip_depth", where=hand) == pytest.approx(depth, abs=1e-3)
    assert value("dip_depth", where={**hand, "K1": 2.53, "B1": 0.01265, "K2": 0.253, "B2": 1.265e-3}) == 0.0
    assert value("dip_depth", where=hand, pulse_s=0.005) == 0.0


def test_network_loses_energy_by_its_dampers_only() -> None:
    """Kinetic and elastic energy of Equation 1 fall at the rate of B1 and B2, in any state: no sign is wrong."""
    j1, b1, k1, j2, b2, k2 = (WHERE[name] for name in ("J1", "B1", "K1", "J2", "B2", "K2"))
    state = np.array([0.3, -1.1, 0.7, 2.3])
    rates = network(WHERE)[0] @ state
    tb, wb, ta, wa = state
    power = j2 * wb * rates[1] + j1 * wa * rates[3] + k1 * ta * wa + k2 * (tb - ta) * (wb - wa)
    assert power == pytest.approx(-b1 * wa**2 - b2 * (wb - wa) ** 2)


def test_a_fit_finds_the_inertia_that_is_there() -> None:
    """With a finger held fast the network is of second order, and the fit exact; with it carried along, both move."""
    pulse = {"pulse_torque": 0.03, "pulse_s": 0.02, "samples": 400, "sample_rate_hz": 1e4}
    fast = {"J1": 3e-7, "B1": 1e4, "K1": 1e6, "J2": 2e-6, "B2": 1e-3, "K2": 0.2}
    assert value("fitted_inertia", where=fast, **pulse) == pytest.approx(2e-6, rel=1e-6)
    along = {"J1": 3e-7, "B1": 1e-3, "K1": 0.2, "J2": 2e-6, "B2": 1e3, "K2": 1e5}
    # At the two edges of the pulse only the knob has moved; the more samples between, the less these two weigh.
    fine = pulse | {"samples": 40_000, "sample_rate_hz": 1e6}
    assert value("fitted_inertia", where=along, **fine) == pytest.approx(2.3e-6, rel=1e-3)


def test_every_computation_says_what_it_is() -> None:
    assert len(known()) >= 20
    assert all(function.__doc__ for function in known().values())
