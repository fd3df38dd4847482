"""Theory beside simulation: describing functions, exact relay cycles, closed laws, stability limits.

- `relay` describing functions, Tsypkin's locus and the Nyquist picture
- `attached` a finger, a lag, friction beside the relay's body; `staircase` the whole wall in its place, and a bounded
  lag
- `sampled_relay` exact cycles
- `laws` at the working edge, `passivity`, and further `criteria` on the `sampled_plant`
"""
