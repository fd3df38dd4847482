"""Result files: their columns, provenance, and how they are written."""
