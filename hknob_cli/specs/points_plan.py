"""Points of a design as plain values: how many, by which rule, and which axes are ranges."""

from typing import NamedTuple


class Points(NamedTuple):
    """A design: ``number`` points by a ``method`` (sobol, halton, latin_hypercube, random) and its ``seed``.

    ``scales``: log or lin, by the name of each axis that is a range; the axis then holds its two ends.
    """

    method: str
    number: int
    seed: int
    scales: dict[str, str]
