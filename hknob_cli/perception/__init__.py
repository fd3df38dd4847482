"""Whether anyone will feel or hear a buzz: published thresholds, as data, and levels above them.

- `touch` (vibration and torque steps), `hearing` (ISO 226) levels above them
- `level` published thresholds as data, how parts combine, and what a judgment may be wrong by
- `sound` a clip to listen to
"""
