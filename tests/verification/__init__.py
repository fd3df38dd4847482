"""Verification: the package against equations, certificates and a 60-digit model of its own."""
