"""Result files: their columns, provenance, and how they are written.

- `columns` names, units, meanings
- `arrays`, `store` (`place` refuses symbolic links), `provenance`
- `staging` what an unfinished run has finished, `parted` tables in parts, `parting` where they are cut
- `ranged` of which starts a largest cycle is
- `result_set` results by name, `matching` rows of them
- `campaign_cells` trials as cells of a sweep

Files whole or not at all. Everything is written beside its place and renamed; a folder has one writer at a time (a
lock that the kernel drops with the process); files of another origin are refused; equal provenance means up to date.
"""
