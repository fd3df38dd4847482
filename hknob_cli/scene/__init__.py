"""Scenes reduced to the smallest set of numbers that the engine runs on."""
