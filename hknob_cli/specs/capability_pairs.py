"""Verdicts of `specs.capabilities`, and the pairs of parts whose verdict is lower than that of each of them."""

from typing import NamedTuple

PROVEN, EXACT, ESTIMATED, REFUSED = "P", "E", "~", "-"
WORDS = {PROVEN: "exact and proven", EXACT: "exact", ESTIMATED: "estimated", REFUSED: "refused"}
LOWEST_FIRST = REFUSED + ESTIMATED + EXACT + PROVEN


class Lower(NamedTuple):
    """The verdict of a pair of parts in a column, and why.

    ``unless`` a scene has one of these parts, too; and only ``beside`` all of these.
    """

    verdict: str
    why: str
    unless: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()


# Pairs of parts whose verdict in a column is lower than that of each of them.
EXCEPTIONS = {
    **{
        (part, "virtual_damping", column): Lower(
            REFUSED,
            "the plain wall remembers one count there, not those of the last turning point and of the last sample: "
            "it is followed as a controller",
        )
        for part in ("hysteresis", "backlash")
        for column in ("general", "general_sets")
    },
    **{
        (part, other, "friction_sets"): Lower(
            REFUSED, "another engine follows such sets, or none", ("friction", *unless)
        )
        for part in ("hysteresis", "backlash")
        for other, *unless in (("controller", "several_readings"), ("virtual_damping",), ("lag",), ("current_loop",))
    },
    **{
        ("cogging", part, "friction_arcs"): Lower(REFUSED, "arcs have no turning points on slopes of cogging")
        for part in ("hysteresis", "backlash")
    },
    ("cogging", "bare", "general"): Lower(EXACT, "a cycle that passes a corner is proven by counts"),
    ("cogging", "speed_sensor", "laws"): Lower(EXACT, "the torque follows a motion that is not affine"),
    **{
        (part, "cogging", column): Lower(
            EXACT, "friction lets two motions over corners go at other times there", beside=("friction",)
        )
        for part in ("finger", "lag", "coil", "current_loop", "mesh")
        for column in ("general", "laws")
    },
    **{
        (part, "cogging", "friction_arcs"): Lower(
            REFUSED, "friction lets two motions over corners go at other times there", beside=("friction",)
        )
        for part in ("finger", "lag", "coil", "current_loop", "mesh")
    },
    ("friction", "bare", "general"): Lower(EXACT, "the period map is not shown to contract"),
    ("friction", "speed_sensor", "laws"): Lower(EXACT, "the torque follows the motion, which is not affine"),
    **{
        (part, "speed_sensor", "laws"): Lower(EXACT, "how far motions part between samples is not bounded")
        for part in ("hysteresis", "backlash")
    },
    ("bare", "by_counts", "laws"): Lower(
        REFUSED, "there is no count to be worth so much, to change, or to be rounded to"
    ),
}
