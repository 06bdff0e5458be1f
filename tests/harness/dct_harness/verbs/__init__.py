"""The verbs of `dct-harness`, one a module: `add` puts it on the command line."""
