"""What a text prints, as data: its tables, and what follows from their digits.

- `tables` rows and digits of the dissertation's tables, and the hand models in them
"""
