"""The command line: one file per subcommand, nothing but talking to the user."""
