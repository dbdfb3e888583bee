"""Resistance of the whole plate."""


def mean(run, values):
    """Mean over all steps, which are equally long, N. The values of explicit dynamics are themselves means over their
    steps, so this is the work of the pull over its distance."""
    return 2. * run.body("body1_reaction force_x").mean()
