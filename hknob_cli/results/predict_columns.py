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

PASSIVITY = (
    Column("colgate_schenkel", _FLAG, "", "b > K T / 2 + |B|"),
    Column("abbott_okamura", _FLAG, "", "K <= min(2 b / T, 2 T_c / q)"),
    Column("gil_hulin", _FLAG, "", "K < (b + B) / (T / 2 + t_d)"),
    Column("niemeyer", _FLAG, "", "q <= T_c / K"),
    Column("colgate_schenkel_load", _REAL, "1", "(K T / 2 + |B|) / b; holds below 1; null where infinite"),
    Column("abbott_okamura_load", _REAL, "1", "K / min(2 b / T, 2 T_c / q); holds up to 1; null where infinite"),
    Column("gil_hulin_load", _REAL, "1", "K (T / 2 + t_d) / (b + B); holds below 1; null where infinite"),
    Column("niemeyer_load", _REAL, "1", "K q / T_c; holds up to 1; null where infinite"),
    Column("binding_limb", _TEXT, "", "the limit with the largest load"),
    Column("rate_needed_hz", _REAL, "Hz", "least sample rate that satisfies all limits on it; null if none does"),
    Column("damping_needed_nm_s_per_rad", _REAL, "N*m*s/rad", "least b that satisfies all limits on it"),
    Column("counts_needed", _WHOLE, "1/rev", "fewest counts that satisfy all limits on them; null if none do"),
    Column("friction_needed_nm", _REAL, "N*m", "least Coulomb friction that satisfies all limits on it"),
)
