"""Stage sweep: every limit cycle of a grid.

- `cell` one of a sweep, `every_start` all its starts, `plain_chunk` a run of plain ones
- `tables`, of attractors in columns
- `assembly` of pieces, for long sweeps
- `perceived` sizes and levels of a cell, `record`, `starts` columns and maps of many starts
"""
