"""Measures of a proven orbit: extremes, integrals, energy."""
