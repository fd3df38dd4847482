"""``python -m hknob_cli``: the same as ``hknob``."""

from hknob_cli.cli.main import main

main()
