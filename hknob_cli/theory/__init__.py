"""Theory beside simulation: describing functions, exact relay cycles, closed laws, stability limits.

- `relay` describing functions and Tsypkin's locus
- `sampled_relay` exact cycles
- `laws`, `working_edge`, `passivity`
- `bounded_lag` its domain and rule
"""
