"""Stage dfa: limit cycles from the frequency response."""
