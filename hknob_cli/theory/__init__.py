"""Theory beside simulation: describing functions, exact relay cycles, closed laws, stability limits.

- `relay` describing functions, Tsypkin's locus and the Nyquist picture
- `sampled_relay` exact cycles
- `laws` at the working edge, `passivity`
- `bounded_lag` its domain and rule
"""
