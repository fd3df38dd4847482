"""The columns of the predictions' files, beside the grid axes."""

import pyarrow as pa

from hknob_cli.results.columns import Column

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()

PREDICTIONS = (
    Column("law", _TEXT, "", "quantum_period, describing_function or energy_balance"),
    Column("p2p_rad", _REAL, "rad", "peak to peak; null where the law has no value"),
    Column("amplitude_rad", _REAL, "rad", "half of p2p_rad"),
    Column("frequency_hz", _REAL, "Hz", "frequency; null where the law has no value"),
    Column("rms_rad", _REAL, "rad", "root mean square of parabolic arcs, sqrt(8/15) / 2 of p2p_rad"),
    Column("rms_sine_rad", _REAL, "rad", "root mean square by the dissertation's factor, .707 / 2 of p2p_rad"),
    Column("in_domain", _FLAG, "", "whether the law's assumptions hold"),
    Column("reason", _TEXT, "", "the first assumption that does not hold; empty where all do"),
)

# b_k: damping of the knob alone; b: of knob and hand; B: virtual damping; T: sample period; t_d: transport delay;
# q: one count; T_c: Coulomb friction. A delay of part of a sample asks for up to 8 % more than T / 2 + t_d says.
PASSIVITY = (
    Column("device_passive", _FLAG, "", "passive whoever holds the knob: colgate_schenkel and abbott_okamura hold"),
    Column(
        "colgate_schenkel",
        _FLAG,
        "",
        "passivity of the device: b_k > K (T / 2 + t_d) + |B|, with b_k of the knob alone",
    ),
    Column("abbott_okamura", _FLAG, "", "passivity of the device: K <= min(b_k / (T / 2 + t_d), 2 T_c / q)"),
    Column("gil_hulin", _FLAG, "", "stability with this hand: K < (b + B) / (T / 2 + t_d), b of knob and hand"),
    Column("niemeyer", _FLAG, "", "no oscillation over one count, in any hand: q <= T_c / K"),
    Column("colgate_schenkel_load", _REAL, "1", "(K (T / 2 + t_d) + |B|) / b_k; holds below 1; null where infinite"),
    Column("abbott_okamura_load", _REAL, "1", "K / min(b_k / (T / 2 + t_d), 2 T_c / q); holds up to 1; null: infinite"),
    Column("gil_hulin_load", _REAL, "1", "K (T / 2 + t_d) / (b + B); holds below 1; null where infinite"),
    Column("niemeyer_load", _REAL, "1", "K q / T_c; holds up to 1; null where infinite"),
    Column("binding_limb", _TEXT, "", "which of these four limits has the largest load"),
    Column("rate_needed_hz", _REAL, "Hz", "least sample rate that satisfies these limits; null if none does"),
    Column("damping_needed_nm_s_per_rad", _REAL, "N*m*s/rad", "least damping of the knob that satisfies these limits"),
    Column("counts_needed", _WHOLE, "1/rev", "fewest counts that satisfy these limits; null if none do"),
    Column("friction_needed_nm", _REAL, "N*m", "least Coulomb friction of the knob that satisfies these limits"),
)
# Only where the scene has a hand.
WITH_HAND = (
    Column(
        "colgate_schenkel_with_hand", _FLAG, "", "b > K (T / 2 + t_d) + |B|: no oscillation with this hand's damping"
    ),
    Column("abbott_okamura_with_hand", _FLAG, "", "K <= min(b / (T / 2 + t_d), 2 T_c / q), b of knob and hand"),
    Column("colgate_schenkel_with_hand_load", _REAL, "1", "(K (T / 2 + t_d) + |B|) / b; null where infinite"),
    Column("abbott_okamura_with_hand_load", _REAL, "1", "K / min(b / (T / 2 + t_d), 2 T_c / q); null where infinite"),
    Column("binding_limb_with_hand", _TEXT, "", "the limit with the largest load, the hand's damping counted in all"),
    Column("rate_needed_with_hand_hz", _REAL, "Hz", "as rate_needed_hz, the hand's damping counted in all limits"),
    Column(
        "damping_needed_with_hand_nm_s_per_rad",
        _REAL,
        "N*m*s/rad",
        "least damping of knob and hand together that satisfies all limits, the hand's counted in all",
    ),
)
