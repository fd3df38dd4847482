"""Every start at once: sets of states followed as exactly as single trials, cut only where a count edge parts them."""
