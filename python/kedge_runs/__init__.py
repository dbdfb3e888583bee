"""Runs of Kedge: starts the program and reads its output folders. kedge-plot, the scene tests and the benchmarks use it."""


class RunError(Exception):
    """A problem that the user can solve, such as a missing file. The message says what is wrong and where."""
