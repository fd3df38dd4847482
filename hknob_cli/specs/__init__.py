"""Specs: YAML to validated models, every fault with its place.

- `source` YAML with places, `size_limit` how large
- `quantity` units
- `scene`, `hand`, `population`, `grid`, `points` (a design), `sweep` the validating models
- `grid_axes` values of the axes, `cells` the cells by number, `unit_points` those of a design
- `hand_from`, `find_people` hands from `conditions`
- `parquet` that is text where it says so
- `capabilities` what goes with what, one table
- `refusals` its faults, `promise` what will not be proven
- `load` faults
- `plan` the plain values that leave this folder
- `drawings` the names of the figures
"""
