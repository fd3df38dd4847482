"""Specs: YAML to validated models, every fault with its place.

- `source` YAML with places, `named_file` which files are read, and one without a file
- `parts`, `controller`, `perception` what is declared once: read, held to bounds and used as it stands there
- `quantity` bounds of values, and from text with a unit to SI
- `scene`, `hand`, `grid`, `sweep` models of what a spec writes in another way
- `cells` the cells by number, `unit_points` those of a design
- `hand_from`, `find_people` hands and people from files
- `parquet` files, checked as they are read
- `capabilities` what goes with what, one table
- `refusals` what it refuses, as faults (`scene` has what else a scene excludes), and values of axes, `remarks` what may
  stay unproven
- `load` a file to its plan, `scene_paths` faults with their places, `messages` in a user's words
- `plan`, `stage_plans` the plain values that leave this folder
- `drawings` the names of the figures
"""
