"""Shared by the checks: the repository's files, their include lines, and the report of findings."""
import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

_INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def options(description):
    """A parser with the option --root."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--root", type=pathlib.Path, default=ROOT, help="repository to check (default: this one)")
    return parser


def files(root):
    """Files that git tracks or does not ignore, relative to the root; without git, every file outside hidden and build
    folders."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                            cwd=root, capture_output=True, check=False)
    if listed.returncode == 0:
        names = {pathlib.Path(name) for name in listed.stdout.decode().split("\0") if name}
    else:
        names = {path.relative_to(root) for path in root.rglob("*")}
        names = {name for name in names if not any(part.startswith((".", "build")) for part in name.parts)}
    return sorted(name for name in names if (root / name).is_file())


def read_lines(path):
    """Lines of a text file; None if the file is no text."""
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError:
        return None


def includes(path):
    """Line number, name and opening bracket of every include line of a source file."""
    return [(number, match[2], match[1]) for number, line in enumerate(read_lines(path) or [], 1)
            if (match := _INCLUDE.match(line))]


def finish(findings, fine):
    """Prints the findings, or the line `fine` if there are none; ends the program with the exit code."""
    for finding in findings:
        print(finding)
    print(f"{len(findings)} finding{'s' if len(findings) != 1 else ''}" if findings else fine)
    sys.exit(1 if findings else 0)
