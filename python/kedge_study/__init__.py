"""Studies: many runs of one scene, what they answer, and what they cost. The command is kedge-study."""
from kedge_runs import RunError


class StudyError(RunError):
    """A study that cannot be read or made. The message names the file, the place in it and the remedy."""
