"""What each verb of the command line does, one a module; see `experiments.cli.VERBS`."""
