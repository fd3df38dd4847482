"""Whether anyone will feel or hear a buzz: published thresholds, as data, and levels above them.

- `published` thresholds as data
- `touch`, `torque_step`, `hearing` (ISO 226) levels above them
- `level` how parts combine, `doubt` what a judgment by thresholds may be wrong by
- `sound` a clip to listen to
"""
