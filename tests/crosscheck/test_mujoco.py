"""One trial against MuJoCo: a hinge with inertia, damping and spring, its motor driven by the sampled wall."""

from math import floor, pi

import pytest

from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import SPEC, loaded

mujoco = pytest.importorskip("mujoco")

HINGE = """
<mujoco>
  <option timestep="{step}" integrator="RK4" gravity="0 0 0"/>
  <worldbody><body>
    <joint name="knob" type="hinge" axis="0 0 1" damping="3.45e-4" stiffness="0.04"/>
    <inertial pos="0 0 0" mass="1e-3" diaginertia="2.2e-6 2.2e-6 2.2e-6"/>
  </body></worldbody>
  <actuator><motor joint="knob"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize(("rate", "counts"), [(1000, 512), (2000, 1024)])
def test_peak_to_peak_of_the_orbit_reached(rate: int, counts: int) -> None:
    substeps = 8
    model = mujoco.MjModel.from_xml_string(HINGE.format(step=1 / (rate * substeps)))
    data = mujoco.MjData(model)
    stage = SweepStage(loaded(SPEC.replace("[1000]", f"[{rate}]").replace("[1024]", f"[{counts}]")))
    result = stage.run_cell({"sample_rate_hz": float(rate), "counts_per_rev": counts})
    quantum = 2 * pi / counts
    data.qpos[0] = 0.02
    highest, lowest = -1.0, 1.0
    for sample in range(rate):  # one second
        measured = quantum * floor(data.qpos[0] / quantum)
        data.ctrl[0] = (-0.27 * measured if measured < 0 else 0.0) - 0.001
        for _ in range(substeps):
            mujoco.mj_step(model, data)
            if sample > rate // 2:
                highest, lowest = max(highest, data.qpos[0]), min(lowest, data.qpos[0])
    # Peaks are seen at physics steps only: missed by at most a dt^2 / 8, a the largest acceleration.
    missed = (0.27 * quantum + 0.001) / 2.2e-6 / (rate * substeps) ** 2 / 8
    gaps = [abs((highest - lowest) - (m.max_rad - m.min_rad)) for m in result.measures]
    assert min(gaps) < 2 * missed + 1e-6
