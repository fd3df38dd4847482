"""``python -m hknob_cli``: the same as ``hknob``."""

from hknob_cli.cli.app import main

main()
