"""The numbers of docs/explanation/perception.md: the main grid felt and heard, and how well levels are known."""

from functools import cache
from math import log10

import numpy as np
import pandas as pd

from hknob_cli.perception.level import published
from hknob_cli.perception.touch import detection_threshold
from tests.conftest import EXPERIMENTS, swept

from .page import agrees, says, table

PAGE = "explanation/perception.md"
SETS = ("pen_hold", "cylinder", "thenar", "thenar_1988")


@cache
def felt(thresholds: str = "pen_hold", extrapolate: str = "false") -> pd.DataFrame:
    """Cells of the main grid, as it is felt, by rate and counts."""
    how = f"perceive={{knob_radius: 8.9 mm, extrapolate: {extrapolate}, touch: {{thresholds: {thresholds}}}}}"
    cells = swept(EXPERIMENTS / "hand_on_knob_perceived.yaml", how).cells.to_pandas()
    return cells.assign(rate=cells.sample_rate_hz.round()).set_index(["rate", "counts_per_rev"])


def test_the_main_grid_felt() -> None:
    cells, thenar = felt(), felt("thenar")
    less = cells.touch_db - thenar.touch_db
    size = cells.p2p_rad
    says(
        PAGE,
        f"every cell is felt, by {cells.touch_db.min():.0f} to {cells.touch_db.max():.0f} dB",
        f"{(thenar.touch_db > 0.0).sum()} of 49 are (`touch: {{thresholds: thenar}}`; on average "
        f"{less.mean():.0f} dB less)",
        f"mean of the 49 cells of the main grid ({less.min():.0f} to {less.max():.0f} in single cells) | "
        f"{less.mean():.0f} dB",
    )
    assert (cells.touch_db > 0.0).all()
    assert agrees("5.0", 1e-3 * size.max() / size.min())
    assert published("touch")["between_sets_db"] == round(less.mean())


def test_faster_and_finer() -> None:
    cells = felt()
    slow, fast = cells.loc[1000.0], cells.loc[10000.0]
    smaller = slow.p2p_rad / fast.p2p_rad
    touch, sound = (fast[name] - slow[name] for name in ("touch_db", "hearing_relative_db"))
    says(
        PAGE,
        f"makes the cycles {smaller.min():.0f} to {smaller.max():.0f} times smaller "
        f"(\u2212{20 * log10(smaller.min()):.0f} to \u2212{20 * log10(smaller.max()):.0f} dB)",
        f"falls by {-touch.max():.0f} to {-touch.min():.0f} dB only and sound changes by "
        f"\u2212{-sound.min():.0f} to +{sound.max():.0f} dB",
        "(512 to 2048) cost "
        f"{20 * log10(slow.p2p_rad[512] / slow.p2p_rad[2048]):.0f} dB in size, "
        f"{slow.touch_db[512] - slow.touch_db[2048]:.0f} dB in touch and "
        f"{slow.hearing_relative_db[512] - slow.hearing_relative_db[2048]:.0f} dB in sound",
    )
    steps = felt(extrapolate="true").torque_step_db
    says(PAGE, f"The steps of torque are {steps.min():.0f} dB (8192 counts) to {steps.max():.0f} dB (128)")


def test_the_whine_felt_and_heard() -> None:
    how = "perceive={knob_radius: 8.9 mm, sound_gain: 0.02 Pa/(rad/s)}"
    orbits = {
        name: swept(EXPERIMENTS / f"{name}.yaml", how, "record=null").orbits.to_pandas()
        for name in ("whine", "whine_friction")
    }
    plain, rubbed = orbits["whine"], orbits["whine_friction"]
    often = plain.loc[plain.basin_fraction.idxmax()]
    heard = rubbed.hearing_db.max()
    says(
        PAGE,
        f"is felt by {plain.touch_db.max():.0f} dB",
        f"whines at {1e-3 * rubbed.frequency_hz.max():.1f} kHz: what it has up to 320 Hz, where thresholds end, is "
        f"{-rubbed.touch_db.max():.0f} dB *below* them",
        f"{plain.hearing_db.max() - heard:.0f} dB less audible than the loudest cycle without friction "
        f"({often.hearing_db - heard:.0f} dB less than the one that most trials reach)",
    )


def test_the_sets_of_thresholds() -> None:
    """Levels re 1 um, peak, in the table; how far the sets are apart at 150 Hz."""
    for row, name in zip(table(PAGE, "Four sets of thresholds"), SETS, strict=True):
        assert f"`{name}`" in row[0]
        for printed, hertz in zip(row[2:7], (10.0, 40.0, 80.0, 160.0, 250.0), strict=True):
            if printed:
                assert agrees(printed, 20.0 * log10(float(detection_threshold(hertz, name=name)) / 1e-6)), (name, hertz)
        assert f"({published('touch')['thresholds'][name]['known_to_db']} dB)" in row[-1]
    levels = [20.0 * np.log10(detection_threshold(150.0, name=name)) for name in SETS]
    says(PAGE, f"least to largest of the four sets | {max(levels) - min(levels):.0f} dB |")


def test_torque_steps() -> None:
    found = published("torque")["thresholds"]["sinusoid"]
    says(
        PAGE,
        f"{100.0 * found['torque_nm'] / found['base_torque_nm']:.2f} % of 30 mN·m, {1e3 * found['torque_nm']:.2f} mN·m",
        f"the largest average is {100.0 * found['largest_nm'] / found['base_torque_nm']:.0f} %, "
        f"{20.0 * log10(found['largest_nm'] / found['torque_nm']):.0f} dB more",
    )
