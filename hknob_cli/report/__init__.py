"""What a person reads on the terminal: words and tables.

- words and tables, a file a stage
- `what_matters` where no map can be drawn
"""
