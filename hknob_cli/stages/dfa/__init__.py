"""Stage dfa: limit cycles from the frequency response.

- `run` every method over the grid, beside a sweep's complete lists
"""
