"""How far a device's clock may be from this computer's."""

from hknob_cli.hardware.port import Drift

MOST_DRIFT = 0.01  # by which share the clocks may differ; quartz clocks differ by 1e-4 at most


def drift_fault(drift: Drift | None) -> str:
    """What is wrong with a clock that differs so; empty if nothing is."""
    if drift is None or drift.at_least <= MOST_DRIFT:
        return ""
    how = "fast" if drift.share > 0.0 else "slow"
    return (
        f"the target's clock is {abs(drift.share):.1%} {how} by this computer's (sure to {drift.uncertainty:.1%}, "
        f"at most {MOST_DRIFT:.0%} is allowed): its times are wrong, or its loop does not run at the rate it was told"
    )
