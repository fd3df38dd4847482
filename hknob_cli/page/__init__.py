"""The page: figures, claims and provenance as one self-contained HTML file."""
