"""Result files: their columns, provenance, and how they are written.

- `columns` names, units, meanings; the largest cycle of a cell, of which starts it is, and the mean beside it
- `arrays`, `store`, `provenance`, `parted` tables in parts
- `files` refuses symbolic links, and has what an unfinished run has finished
- `result_set` results by name, and rows of them
- `campaign_files` a campaign's columns, and its trials as cells of a sweep

Files whole or not at all. Everything is written beside its place and renamed; a folder has one writer at a time (a
lock that the kernel drops with the process); files of another origin are refused; equal provenance, and a seal that
holds (`specs.seal`), mean up to date.
"""
