"""Every start at once: sets of states followed as exactly as single trials, cut only where a count edge parts them.

- `ball` a set of states sample by sample, and what captures it, `arc` all clock phases, `arc_cut` where they cross
  edges, `polygon` and `box` all starts in a range, `region` and `absorbing` what all motions come into, `cells` many
  cells at once, `search` them all

All starts at once (`engine/sets/`). Between count edges a set of states moves as one trial. It is followed by its
centre and a radius, in the norm that never grows. Only where that ball meets an edge is the set itself looked at, and
cut. What rounding could put on either side goes on in both parts. A set is done where a proven orbit captures it.
Clock phases of one start are arcs, known in closed form. Ranges are polygons, merged when small, so that motions that
come together are followed once. The list of attractors is then complete for those starts
(docs/explanation/every_start.md).
"""
