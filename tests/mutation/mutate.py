#!/usr/bin/env python3
"""Mutation score of the session's rules: how many small faults, put into them at random, the tests find.

mutate.py [--count N] [--seed S] [--jobs J] [--work FOLDER] [--json FILE]

It works in a copy of the last commit, in FOLDER, and builds there without unity. Each fault changes one place of
one of FILES. A fault that does not compile is drawn anew. One that the tests do not find is printed with its place.
"""
import argparse
import json
import pathlib
import random
import re
import subprocess
import sys
import time

FILES = """
collab/ownership/ownership.cpp collab/ownership/ownership_disputes.cpp collab/ownership/ownership_messages.cpp collab/session/peer_directory.cpp
collab/receive/peer_inbox.cpp collab/receive/sample_validator.cpp collab/session/scene_agreement.cpp collab/mirror/remote_bodies.cpp
collab/coupling/energy_gate.cpp collab/coupling/force_terms.cpp
""".split()

# what is looked for, and what takes its place
OPERATORS = [
    (r" < ", [" <= ", " > "]),
    (r" > ", [" >= ", " < "]),
    (r" <= ", [" < "]),
    (r" >= ", [" > "]),
    (r" == ", [" != "]),
    (r" != ", [" == "]),
    (r" && ", [" || "]),
    (r" \|\| ", [" && "]),
    (r" \+ ", [" - "]),
    (r" - ", [" + "]),
    (r"\btrue\b", ["false"]),
    (r"\bfalse\b", ["true"]),
    (r"(?<=[(& |])!(?=[a-z(])", [""]),
    (r"std::max\(", ["std::min("]),
    (r"std::min\(", ["std::max("]),
    (r"\+\+(?=[a-z])", ["--"]),
    (r"\bcontinue;", ["break;"]),
]
STATEMENT = re.compile(r"^\s+(?!return\b|const\b|static\b|auto\b|using\b|case\b|break\b)[\w:.>()\[\]-]+(\(| = | \+= ).*;\s*$")
LEFT_ALONE = re.compile(r"^\s*(//|#|template|namespace|static_assert)|TANDEM_|operator|<<|static constexpr|^constexpr|Tell\(|Notify\(")

# the tests that must find them; the second is run only when the first finds nothing
TESTS = [
    ["collab_test"],
    ["simulator_test", "--gtest_filter=Simulator.NoSeed*"],
]
SECONDS_FOR_A_TEST = 600


def mutants_of(root):
    """All places: (file, line number, column, old text, new text)."""
    found = []
    for file in FILES:
        for number, line in enumerate((root / file).read_text().splitlines()):
            code = line.split("//")[0]
            if not code.strip() or LEFT_ALONE.search(code):
                continue
            for pattern, others in OPERATORS:
                for match in re.finditer(pattern, code):
                    found += [(file, number, match.start(), match.group(), other) for other in others]
            if STATEMENT.match(code):
                found.append((file, number, 0, line, ""))
    return found


def run(command, seconds, **more):
    try:
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=seconds, **more)
        return done.returncode
    except subprocess.TimeoutExpired:
        return -1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("/tmp/tandem-mutation"))
    parser.add_argument("--json", type=pathlib.Path)
    asked = parser.parse_args()

    source = pathlib.Path(__file__).resolve().parents[2]
    root, build = asked.work / "source", asked.work / "build"
    root.mkdir(parents=True, exist_ok=True)
    archive = subprocess.run(["git", "-C", source, "archive", "HEAD"], check=True, capture_output=True)
    subprocess.run(["tar", "-x", "-C", root], input=archive.stdout, check=True)
    commit = subprocess.run(["git", "-C", source, "rev-parse", "--short", "HEAD"], check=True, capture_output=True, text=True)

    programs = [test[0] for test in TESTS]
    make = ["ninja", f"-j{asked.jobs}", "-C", str(build), *programs]
    configured = subprocess.run(
        ["cmake", "-S", root, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O1"],
        stdout=subprocess.DEVNULL)
    if configured.returncode != 0 or subprocess.run(make, stdout=subprocess.DEVNULL).returncode != 0:
        sys.exit(f"{root} cannot be built")

    def found_by():
        for test in TESTS:
            program = [str(build / "bin" / test[0]), *test[1:], "--gtest_fail_fast"]
            if run(program, SECONDS_FOR_A_TEST, cwd=build) != 0:
                return test[0]
        return None

    if found_by() is not None:
        sys.exit("the tests fail without a fault")

    drawn = mutants_of(root)
    random.Random(asked.seed).shuffle(drawn)
    print(f"{len(drawn)} places, seed {asked.seed}, commit {commit.stdout.strip()}", flush=True)
    rows, not_compiled = [], 0
    for file, number, column, old, new in drawn:
        if len(rows) == asked.count:
            break
        path = root / file
        whole = path.read_text()
        lines = whole.splitlines(keepends=True)
        line = lines[number]
        lines[number] = line[:column] + new + line[column + len(old):]
        path.write_text("".join(lines))
        begun = time.monotonic()
        try:
            compiles = run(make, SECONDS_FOR_A_TEST) == 0
            finder = found_by() if compiles else None
        finally:
            path.write_text(whole)
        if not compiles:
            not_compiled += 1
            continue
        rows.append({"file": file, "line": number + 1, "was": line.strip(), "became": lines[number].strip(),
                     "found_by": finder, "seconds": round(time.monotonic() - begun, 1)})
        if finder is None:
            print(f"not found: {file}:{number + 1}: {line.strip()}\n     became: {lines[number].strip()}", flush=True)
    found = sum(row["found_by"] is not None for row in rows)
    print(f"{found} of {len(rows)} faults were found; {not_compiled} more did not compile")
    if asked.json:
        asked.json.write_text(json.dumps({"commit": commit.stdout.strip(), "seed": asked.seed, "faults": rows}, indent=1))


if __name__ == "__main__":
    main()
