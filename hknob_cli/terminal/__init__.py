"""The terminal: messages, progress, keys, and interruptions.

- `console` messages, progress and interruptions
- `keys` what an operator presses
"""
