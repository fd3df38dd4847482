"""Theory beside simulation: describing functions, exact relay cycles, closed laws, stability limits."""
