"""Whether anyone will feel or hear a buzz: published thresholds, as data, and levels above them.

- `published` thresholds as data, and what a judgment by them may be wrong by
- `touch`, `torque_step`, `hearing` (ISO 226) levels above them
- `level` how parts combine
- `sound` a clip to listen to
"""
