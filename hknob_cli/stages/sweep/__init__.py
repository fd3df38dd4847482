"""Stage sweep: every limit cycle of a grid.

- `cell` one of a sweep, `every_start` all its starts, `plain_chunk` a run of plain ones
- `tables`, of attractors in columns; `starts_columns` of a search from all starts
- `assembly` of pieces, `spread` for long sweeps
- `perceived`, `record`, `basins` where each start ends
"""
