"""What an identification says of its flags."""

from collections import Counter

from hknob_cli.stages.sysid.text import flag_text


def test_a_flag_keeps_its_numbers() -> None:
    """One by its own words; of several that differ in their numbers the first, which the others are like."""
    once, twice = (
        "trial 3: 8 samples during the pulse, fewer than 10",
        "trial 5: 9 samples during the pulse, fewer than 10",
    )
    assert flag_text("output_error", Counter([once, once])) == f"output_error: {once}"
    assert flag_text("output_error", Counter([once, twice])) == f"output_error: {once}, and alike"
