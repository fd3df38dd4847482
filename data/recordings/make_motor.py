"""Make the recordings of experiments/foreign_motor.yaml: a motor that is known, seen by a stranger's logger.

    python data/recordings/make_motor.py [FOLDER]

A motor of 1200 g*cm^2 with damping 0.3 mN*m*s/rad and friction 0.5 mN*m, without a spring, is pushed by steps, a chirp
and random steps, and is already turning when the logger starts. The logger writes milliseconds, degrees of an encoder
of 4096 counts that is mounted the other way round, and the current in A, of which one makes 0.05 N*m. The script uses
nothing of hknob: it integrates the motion by small steps.
"""

import sys
from pathlib import Path

import numpy as np

INERTIA, DAMPING, FRICTION, TORQUE_CONSTANT = 1.2e-4, 3.0e-4, 5.0e-4, 0.05
RATE_HZ, LENGTH_S, SUBSTEPS, COUNTS = 500.0, 2.0, 200, 4096
TIME = np.arange(round(RATE_HZ * LENGTH_S)) / RATE_HZ
CURRENTS = {
    "steps": 0.4 * np.sign(np.sin(2.0 * np.pi * 0.7 * TIME)),
    "chirp": 0.4 * np.sin(2.0 * np.pi * (0.5 * TIME + 2.5 * TIME**2)),
    "random": 0.4 * np.repeat(np.where(np.random.default_rng(0).random(TIME.size // 20) < 0.5, -1.0, 1.0), 20),
}


def turned(current: np.ndarray) -> np.ndarray:
    """Angle (n,) rad at the samples, the current held from sample to sample."""
    angle, speed, step = 0.3, 2.0, 1.0 / RATE_HZ / SUBSTEPS
    found = np.empty(current.size)
    for i, one in enumerate(current):
        found[i] = angle
        for _ in range(SUBSTEPS):
            torque = TORQUE_CONSTANT * one - DAMPING * speed - FRICTION * np.sign(speed)
            then = speed + step * torque / INERTIA
            angle += 0.5 * step * (speed + then)
            speed = then
    return found


def main() -> None:
    """Write motor_steps.csv, motor_chirp.csv and motor_random.csv."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)
    for name, current in CURRENTS.items():
        counts = np.floor(turned(current) / (2.0 * np.pi) * COUNTS)
        lines = ["t_ms,theta_deg,i_q,temperature"]
        for time, count, one in zip(TIME, counts, current, strict=True):
            lines.append(f"{1e3 * time:g},{-360.0 / COUNTS * count:.4f},{one:.4f},24.5")
        (folder / f"motor_{name}.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
