"""Controllers beside the plain virtual wall, each a small array program, and their exact motion side by side."""
