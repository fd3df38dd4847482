"""The page: figures, claims and provenance as one self-contained HTML file.

- `answers` what each result answers, and the numbers that come first
- `compose` from plan and results, and from the contents of the text that claims are about, to `book`, plain values,
  with sound clips of cycles that have settled
- `layout`, `template/` the HTML
"""
