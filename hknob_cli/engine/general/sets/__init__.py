"""Every start at once, of scenes with more in them than the plain loop has: delay, limits, lag, a finger.

- `cell` what is handed on: the cell that is followed, and the state that a set is told from
- `readings` what acts alike, `drift` exact bounds on roundings, `ball`, `piece` polygons
  in the space of all states, `lattice`, `box`, `curve` and `arc` all clock phases, `known`, `search`
- behind hysteresis `turns` of one motion, `swings` of a set; `parts` and `arc_parts` what pieces, arcs are cut into
- `memory` what all states of a set have in common: commands under way, or what a controller's law remembers
- `afar` what a wall is from far out, for the region that every motion comes into
- with a lag `lagged_step`, `lagged_stops`; with friction `friction_step`, `friction_set`, `friction_piece`,
  `friction_box`, `friction_phases`, `convex`; behind hysteresis, too, `friction_turns`
- with friction and more states all phases of one start: `friction_arc`, moved over a hold, `friction_arc_parts`,
  `friction_arc_rest`, `friction_arcs`, `friction_arc_search`; behind hysteresis `friction_arc_counts`; beside cogging
  `cog_arc`, which goes from corner to corner, and `cog_stop`
- beside cogging ranges: `cog_piece` over a hold, `cog_fold` where friction stops it, `cog_box`, `cog_search`
- under a law, with friction or without, the same and `law_search`: cut at samples and at looks into an interval
"""
