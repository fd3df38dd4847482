"""Theory beside simulation: describing functions, exact relay cycles, closed laws, stability limits.

- `relay` with what is attached to its body: describing functions, Tsypkin's locus and the Nyquist picture
- `staircase` the whole wall in its place, a bounded lag, and exact cycles of the sampled relay
- `laws` at the working edge, `passivity`, and further `criteria` on the `sampled_plant`
"""
