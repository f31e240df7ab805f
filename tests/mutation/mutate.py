#!/usr/bin/env python3
"""Mutation score: how many small faults, put into the checks of guards, of receivers and of the wire, the tests find.

mutate.py [--count N] [--seed S] [--jobs J] [--build FOLDER] [--work FOLDER] [--json FILE] [GROUP...]

N faults of each group are drawn, without N all are tried. A fault changes one line of a copy of one file. That copy alone is
compiled and linked in front of the libraries of FOLDER, which is a build of the release preset with the objects of the
mutated libraries apart (apart.cmake). The tests that lie beside the file run first, then the group's other programs. A fault
that does not compile is drawn anew. One that no test finds is printed with its place. --only-tests-beside leaves out the
others. --known JSON repeats the faults that an earlier run did not find.
"""
import argparse
import concurrent.futures
import json
import pathlib
import random
import subprocess
import sys
import time

from places import mutants_of
from programs import Builder, Mutant, tests_beside

SOURCE = pathlib.Path(__file__).resolve().parents[2]

# files of a group, the program whose tests lie beside them, and what else must find a fault: more programs with filters
GROUPS = {
    "guards": ("engine/safety/*", "safety_test", ["safety_test"]),
    "receive": ("collab/receive/*.cpp", "collab_test", ["collab_test"]),
    "session": ("collab/session/*.cpp", "collab_test", ["collab_test"]),
    "wire": ("collab/dds/wire/*.cpp", "dds_wire_test", ["dds_wire_test"]),
    "ownership": ("collab/ownership/*.cpp", "collab_test", ["collab_test", "simulator_test --gtest_filter=Simulator.NoSeed*"]),
    "coupling": ("collab/coupling/*.cpp", "collab_test", ["collab_test", "simulator_test --gtest_filter=Simulator.NoSeed*"]),
}


def files_of(pattern):
    found = sorted(path.relative_to(SOURCE).as_posix() for path in SOURCE.glob(pattern))
    return [file for file in found if file.endswith((".cpp", ".h"))]


class Group:
    """A group's faults, the programs that must find them, and how long these take without a fault."""

    def __init__(self, name, builder, beside_only):
        self.name = name
        self.pattern, self.program, others = GROUPS[name]
        self.builder = builder
        self.others = [] if beside_only else [other.split() for other in others]
        self.places = [place for file in files_of(self.pattern) for place in mutants_of(SOURCE, file)]
        self.seconds = {}

    def programs(self):
        return {self.program, *(other[0] for other in self.others)}

    def commands(self, file):
        """Returns the runs that must find a fault of the file: program and arguments."""
        beside = tests_beside(SOURCE, file, self.builder.tests_of(self.program))
        return ([[self.program, "--gtest_filter=" + beside]] if beside else []) + self.others

    def measure(self):
        for file in files_of(self.pattern):
            for command in self.commands(file):
                if tuple(command) in self.seconds:
                    continue
                begun = time.monotonic()
                if self.builder.run(command, None, 1200) != 0:
                    sys.exit(f"{' '.join(command)} fails without a fault")
                self.seconds[tuple(command)] = time.monotonic() - begun

    def judge(self, place, number):
        """Returns the place with what found it; nothing if the fault does not compile."""
        begun = time.monotonic()
        with Mutant(self.builder, place, number) as mutant:
            if not mutant.compiled:
                return None
            finder = None
            for command in self.commands(place["file"]):
                program = mutant.link(command[0])
                if program is None:
                    return None
                if self.builder.run(command, program, 20 + 10 * self.seconds[tuple(command)]) != 0:
                    finder = command[0] if command in self.others else "beside"
                    break
        return {**place, "line": place["line"] + 1, "was": place["was"].strip(), "became": place["became"].strip(),
                "group": self.name, "found_by": finder, "seconds": round(time.monotonic() - begun, 1)}


def run_group(group, drawn, count, jobs, keep):
    rows, not_compiled = [], 0
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        waiting = iter(enumerate(drawn))
        under_way = set()
        while True:
            while len(under_way) < jobs and (count is None or len(rows) + len(under_way) < count):
                following = next(waiting, None)
                if following is None:
                    break
                number, place = following
                under_way.add(pool.submit(group.judge, place, f"{group.name}{number}"))
            if not under_way:
                return rows, not_compiled
            done, under_way = concurrent.futures.wait(under_way, return_when=concurrent.futures.FIRST_COMPLETED)
            for row in (future.result() for future in done):
                if row is None:
                    not_compiled += 1
                    continue
                rows.append(row)
                keep(rows)
                if row["found_by"] is None:
                    print(f"not found: {row['file']}:{row['line']}: {row['was']}\n     became: {row['became']}", flush=True)


def drawn_of(group, asked, known):
    if known is not None:
        wanted = {(row["file"], row["was"], row["became"]) for row in known if row["found_by"] is None}
        return [place for place in group.places if (place["file"], place["was"].strip(), place["became"].strip()) in wanted]
    drawn = list(group.places)
    random.Random(asked.seed).shuffle(drawn)
    return drawn


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=f"of {', '.join(GROUPS)}; without: the first four")
    parser.add_argument("--count", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--work", type=pathlib.Path, default=SOURCE / "build/mutation")
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--only-tests-beside", action="store_true")
    parser.add_argument("--known", type=pathlib.Path)
    parser.add_argument("--json", type=pathlib.Path)
    asked = parser.parse_args()

    commit = subprocess.run(["git", "-C", SOURCE, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    builder = Builder(SOURCE, (asked.build or asked.work / "build").absolute(), (asked.work / "faults").absolute())
    groups = [Group(name, builder, asked.only_tests_beside) for name in asked.groups or list(GROUPS)[:4]]
    builder.build(set().union(*(group.programs() for group in groups)), asked.jobs)
    known = json.loads(asked.known.read_text())["faults"] if asked.known else None

    def keep(rows):
        if asked.json:
            asked.json.write_text(json.dumps({"commit": commit, "seed": asked.seed, "faults": rows}, indent=1))

    all_rows = []
    for group in groups:
        group.measure()
        drawn = drawn_of(group, asked, known)
        print(f"{group.name}: {len(drawn)} of {len(group.places)} places, seed {asked.seed}, commit {commit}", flush=True)
        rows, not_compiled = run_group(group, drawn, asked.count, asked.jobs, lambda rows: keep(all_rows + rows))
        all_rows += rows
        found = sum(row["found_by"] is not None for row in rows)
        print(f"{group.name}: {found} of {len(rows)} faults were found; {not_compiled} more did not compile", flush=True)


if __name__ == "__main__":
    main()
