"""What the axes of a grid are called."""

_NAMES = {
    "sample_rate_hz": "sample rate, Hz",
    "counts_per_rev": "encoder, counts per revolution",
    "bias.torque": "bias torque, N·m",
    "hand.stiffness": "hand stiffness, N·m/rad",
    "hand.grip_n": "grip force, N",
    "hand.damping": "hand damping, N·m·s/rad",
    "wall.stiffness": "wall stiffness, N·m/rad",
    "knob.inertia": "knob inertia, kg·m²",
    "knob.damping": "knob damping, N·m·s/rad",
    "knob.coulomb_torque": "Coulomb friction, N·m",
    "hand.inertia": "hand inertia, kg·m²",
    "wall.damping": "virtual damping, N·m·s/rad",
    "encoder.offset_counts": "encoder edges, counts above the wall's",
    "actuator.delay_samples": "delay, samples",
    "actuator.time_constant": "actuator lag, s",
    "hand_inertia_kg_m2": "inertia of the person's hand, kg·m²",
    "hand_damping_nm_s_per_rad": "damping of the person's hand, N·m·s/rad",
    "hand_stiffness_nm_per_rad": "stiffness of the person's hand, N·m/rad",
}


def axis_name(axis: str) -> str:
    """Name of a grid axis, with its unit."""
    return _NAMES.get(axis, axis)
