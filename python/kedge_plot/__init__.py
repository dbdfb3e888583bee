"""Figures from the output folder of a Kedge run: resistance over displacement and sections through the soil."""


class PlotError(Exception):
    """Something the user can mend: a missing file, an unknown field. The message says what and where."""
