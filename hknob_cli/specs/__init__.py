"""Specs: YAML to validated models, every fault with its place.

- `source` YAML with places, `named_file` which files are read, `standard_input` one without a file
- `parts`, `controller`, `perception` what is `declared` once: read, held to bounds and used as it stands there
- `quantity` bounds and units of values, `units` from text with a unit to SI
- `scene`, `hand`, `grid`, `sweep` models of what a spec writes in another way
- `grid_axes` values of the axes, `cells` the cells by number, `unit_points` those of a design
- `hand_from`, `find_people` hands and people from files
- `parquet` files, checked as they are read
- `capabilities` what goes with what, one table
- `refusals` what it refuses, as faults, `scene_faults` what else a scene excludes, `remarks` what may stay unproven
- `load` a file to its plan, `faults` with their places, `messages` in a user's words
- `plan`, `stage_plans` the plain values that leave this folder
- `drawings` the names of the figures
"""
