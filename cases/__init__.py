"""Case files, the runner, the command line, plots and the report: the only package that knows all the others."""
