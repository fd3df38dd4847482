"""The terminal: messages, progress, keys, and interruptions."""
