"""Pictures of a part that a study draws itself from the output of its runs, such as sections."""
import shutil

from kedge_runs.run import Run

from . import records
from .answers import function_of


def draw(study, name, results, folder, work):
    """Pairs of caption and path without ending of a part's own pictures. A picture is drawn anew if all runs of the
    part are there; otherwise the kept one stays."""
    found = []
    for index, (caption, text) in enumerate(study.parts[name].get("pictures", {}).items()):
        file = f"{study.stem_of(name)}-{text.partition(':')[2].replace('_', '-')}"
        if any(path.name == file for _, path in found):  # of a function with the same name
            file += f"-{index + 1}"
        folders = [result.case.folder(work, records.version_of(result.case.program)) for result in results]
        if all((run / "output" / "summary.json").is_file() for run in folders):
            runs = [(result.case.names, Run(run / "output")) for result, run in zip(results, folders)]
            function_of(study, text, f"parts.{name}.pictures[{index}]")(runs, folder / f"{file}.png")
        elif (study.folder / f"{file}.png").is_file() and study.folder != folder.resolve():
            shutil.copyfile(study.folder / f"{file}.png", folder / f"{file}.png")
        if (folder / f"{file}.png").is_file():
            found.append((caption, folder / file))
    return found
