"""The wire to a target, on the host's side: frames, messages, order of blocks, and the link."""
