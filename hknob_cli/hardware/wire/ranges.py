"""What the wire asks of a trial's settings beside the target's ranges: that a block is not long in coming."""

from hknob_cli.hardware.port import Identity, Settings
from hknob_cli.hardware.ranges import faults_of_settings

# A block must come well before silence counts as a dead link.
LONGEST_BLOCK_S = 0.05


def faults(settings: Settings, identity: Identity) -> list[str]:
    """What is out of range for this device, one text for each value."""
    found = faults_of_settings(settings, identity)
    block_s = settings.block_samples * settings.interval_s
    if not found and block_s > LONGEST_BLOCK_S:
        longest = LONGEST_BLOCK_S * 1e3
        found.append(f"block_samples: a block must take at most {longest:g} ms, these take {block_s * 1e3:g} ms")
    return found
