"""Whether anyone will feel or hear a buzz: published thresholds, as data, and levels above them."""
