"""All starts of a wall with a controller at once: sets of states of one memory, side by side, cut at count edges."""
