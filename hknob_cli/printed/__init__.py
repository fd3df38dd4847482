"""What a text prints, as data: its tables, and what follows from their digits."""
