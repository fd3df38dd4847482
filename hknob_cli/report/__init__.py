"""What a person reads on the terminal: words and tables.

- words and tables, a file a stage
- `means` the largest cycle of a cell and the mean beside it
- `what_matters` where no map can be drawn
"""
