"""Ranges of the settings that a target takes (docs/wire.md), checked before they are sent: so the value has a name."""

from hknob_cli.hardware.port import Identity, Settings
from hknob_cli.hardware.wire.answers import MOST_SAMPLES

# A block must come well before silence counts as a dead link.
LONGEST_BLOCK_S = 0.05


def faults(settings: Settings, identity: Identity) -> list[str]:
    """What is out of range for this device, one text for each value."""
    ranges: dict[str, tuple[float, float]] = {
        "period_ns": (identity.shortest_period_ns, 10**9),
        "counts_per_rev": (1, identity.native_counts),
        "wall_stiffness": (0.0, 1e3),
        "wall_damping": (0.0, 1e3),
        "torque_limit_nm": (0.0, 10.0),
        "speed_limit_rad_s": (0.0, 1e4),
        "watchdog_us": (1000, 50_000),
        "block_samples": (1, MOST_SAMPLES),
    }
    found = []
    for name, (low, high) in ranges.items():
        value = getattr(settings, name)
        above_zero = name.endswith(("_nm", "_rad_s"))
        if not (low <= value <= high) or (above_zero and value == 0.0):
            allowed = f"above 0, at most {high:g}" if above_zero else f"{low:g} to {high:g}"
            found.append(f"{name}: must be {allowed}, got {value!r}")
    block_s = settings.block_samples * settings.interval_s
    if not found and block_s > LONGEST_BLOCK_S:
        longest = LONGEST_BLOCK_S * 1e3
        found.append(f"block_samples: a block must take at most {longest:g} ms, these take {block_s * 1e3:g} ms")
    return found
