"""The knob without a sample clock: an exact state machine, from one encoder edge to the next."""
