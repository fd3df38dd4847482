"""The measures of an attractor of the general loop under a controller."""

from math import nan

from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.measure.leak import Leak
from hknob_cli.measure.moments import Array


class LawMeasurer(GeneralMeasurer):
    """As `GeneralMeasurer`; what a late edge and the staircase give out is known of the plain wall alone."""

    def _leak(self, x: Array, commands: Array) -> Leak:
        del x, commands
        return Leak(nan, nan, nan)
