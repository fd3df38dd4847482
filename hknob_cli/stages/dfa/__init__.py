"""Stage dfa: limit cycles from the frequency response.

- `listed`: a sweep's complete lists, and two-level cycles
"""
