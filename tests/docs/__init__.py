"""Numbers that the pages of docs/ state, computed again."""
