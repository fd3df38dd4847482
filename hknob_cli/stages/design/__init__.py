"""Stage design: the cheapest design whose limit cycles nobody minds."""
