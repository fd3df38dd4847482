"""What a person looks at: tables on the terminal, pictures.

- words and tables, a file a stage
- `means` the largest cycle of a cell and the mean beside it
- `what_matters` where no map can be drawn
"""
