"""The loop with whatever else a scene lists: friction, finger, lag, limits, virtual damping, a continuous sensor."""
