"""Starts Kedge and reads its output folders, for kedge-plot, the tests of scenes and the benchmarks."""


class RunError(Exception):
    """A problem that the user can solve, such as a missing file. The message says what is wrong and where."""
