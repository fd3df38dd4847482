"""The pitch of a recorded buzz, in cycles per second, as a sweep counts them."""

from math import pi

LEAST_COUNTS = 10.0  # of the device's own encoder: of a smaller swing it misses maxima


def pitch_hz(
    *, p2p_rad: float, cycle_hz: float, torque_hz: float, native_counts: int, counts_per_rev: int | float
) -> float:
    """Local maxima per second, or, of a swing too small to show them all, rises of the torque per second.

    So small a swing crosses one edge of the wall's encoder, if that is the coarser, and so raises the torque once a
    cycle. ``native_counts``: per revolution of the device's own encoder; ``counts_per_rev``: of the wall's.
    """
    own = 2.0 * pi / native_counts
    small = p2p_rad < LEAST_COUNTS * own < 2.0 * pi / counts_per_rev
    return torque_hz if small else cycle_hz
