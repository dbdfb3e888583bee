"""Figures of a Kedge run: resistance over displacement and sections through the soil."""
from kedge_runs import RunError


class PlotError(RunError):
    """A run does not hold what a figure needs, such as a field. The message says what is missing and where."""


class OptionError(PlotError):
    """An option does not fit: wrong by itself, or for this run."""
