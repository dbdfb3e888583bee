"""Which body, axis and stages a resistance curve shows."""
from dataclasses import dataclass

from . import OptionError


@dataclass
class Choice:
    """body: from 1, as in rigid_body.csv. axis: x, y or z; None: the one along which the body moves most. stages: from
    1; None: all. is_continued: whether the row before them belongs to the same motion, so that the body was neither
    frozen then nor placed since."""
    body: int
    axis: object
    stages: object
    is_continued: bool = True


def choose(scene, reached, body=None, axis=None, stages=None):
    """The curve to draw where the user leaves something open: of the last stage in which a body is prescribed to move,
    for that body and along the axis of this motion; without one, of the stages since the bodies were last placed.

    scene: the effective input, {} if unknown. reached: stages that have rows. body, axis, stages: what the user asks.
    """
    entries = dict(enumerate(scene.get("analysis", []), 1))
    frozen = {number for number, entry in entries.items() if entry.get("rigid bodies") == "off"}
    placed = {number for number, entry in entries.items() if entry.get("rigid body surface placement") == "on"} - frozen
    if stages:
        stages = sorted(set(stages))
        _require_one_motion(stages, frozen, placed)
    open_stages = stages or sorted(set(entries) & set(reached) - frozen)
    motion = {number: _prescribed(scene, entries[number]) for number in open_stages if number in entries}
    of_body = {number: [move for move in moves if body in (None, move[0])] for number, moves in motion.items()}
    last = _last(of_body)
    if last:
        chosen, along, _ = max(of_body[last], key=lambda move: (move[1] == axis, abs(move[2])))
        body, axis = body or chosen, axis or along
    if not stages and open_stages:
        last = last or _last(motion)  # of another body
        since = max(placed & set(open_stages), default=0)
        stages = [last] if last else [number for number in open_stages if number >= since]
    first = stages[0] if stages else 1
    return Choice(body or 1, axis, stages, first not in placed and first - 1 not in frozen)


def _require_one_motion(stages, frozen, placed):
    """Refuses stages whose rows no curve can show together."""
    for stage in stages:
        if stage in frozen:
            raise OptionError(f"--stage {stage}: the bodies are \"off\" in this stage")
        if stage in placed and stage != stages[0]:
            raise OptionError(f"--stage {stage}: the bodies are placed anew in this stage; no curve goes on there")


def _last(motion):
    """The last stage with a motion; None without."""
    return max((number for number, moves in motion.items() if moves), default=None)


def _prescribed(scene, stage):
    """Body, axis, and movement per step of all translations that are prescribed in a stage."""
    axes = "xz" if scene.get("dimension", 3) == 2 else "xyz"
    own = {(entry["system"], entry["point"]): entry["boundary conditions"]
           for entry in stage.get("rigid body boundary conditions", [])}
    points = [own.get((system, point), entry.get("boundary conditions", []))
              for system, of_system in enumerate(scene.get("rigid bodies", []), 1)
              for point, entry in enumerate(of_system.get("points", []), 1)]
    return [(body, axis, condition["prescribed"]) for body, conditions in enumerate(points, 1)
            for axis, condition in zip(axes, conditions) if isinstance(condition, dict) and condition.get("prescribed")]
