"""Every start at once, of scenes with more in them than the plain loop has: delay, limits, lag, a finger."""
