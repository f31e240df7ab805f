#!/usr/bin/env python3
"""Lines that were run: coverage.py BUILD FOLDER...: reads what gcov says of all objects of BUILD, a line a folder."""
import collections
import gzip
import json
import pathlib
import subprocess
import sys
import tempfile

build = pathlib.Path(sys.argv[1]).resolve()
root = pathlib.Path(__file__).resolve().parents[1]
folders = sys.argv[2:]
runs = collections.defaultdict(dict)  # file -> line -> whether it was run
for data in build.rglob("*.gcda"):
    with tempfile.TemporaryDirectory() as scratch:
        subprocess.run(["gcov", "--json-format", data], cwd=scratch, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for report in pathlib.Path(scratch).glob("*.gz"):
            whole = json.loads(gzip.open(report).read())
            for file in whole["files"]:
                path = pathlib.Path(whole["current_working_directory"], file["file"]).resolve()
                if path.is_relative_to(root) and path.relative_to(root).parts[0] in folders:
                    lines = runs[path.relative_to(root)]
                    for line in file["lines"]:
                        number = line["line_number"]
                        lines[number] = lines.get(number, False) or line["count"] > 0

totals = collections.defaultdict(lambda: [0, 0])
for path, lines in runs.items():
    for folder in {path.parts[0], "/".join(path.parts[:2]) if len(path.parts) > 2 else path.parts[0], "all"}:
        totals[folder][0] += sum(lines.values())
        totals[folder][1] += len(lines)
for folder, (run, known) in sorted(totals.items()):
    print(f"{folder}: {100 * run / known:.1f} % of {known} lines of code were run")
