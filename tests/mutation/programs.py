"""Builds test programs with a changed copy of one source, and runs them."""
import json
import pathlib
import re
import shlex
import shutil
import subprocess

TEST = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+),", re.MULTILINE)


def tests_beside(source, file, names):
    """Returns a GoogleTest filter of the suites in the folder of `tests` that mirrors the file's; empty where there is none."""
    folder = source / "tests" / pathlib.Path(file).parent
    suites = {suite for path in folder.glob("*_test.cpp") for suite in TEST.findall(path.read_text())}
    return ":".join(sorted(f"{name}.*" for name in names if name.split("/")[-1] in suites or name.split("/")[0] in suites))


def output_of(command, **more):
    return subprocess.run(command, check=True, capture_output=True, text=True, **more).stdout


class Mutant:
    """One changed copy of a file, compiled. Its folder goes with it."""

    def __init__(self, builder, place, number):
        self.builder, self.folder = builder, builder.work / number
        self.objects, self.compiled = [], False
        copy = self.folder / place["file"]
        shutil.rmtree(self.folder, ignore_errors=True)
        copy.parent.mkdir(parents=True)
        lines = (builder.source / place["file"]).read_text().splitlines()
        lines[place["line"]] = place["became"]
        copy.write_text("\n".join(lines) + "\n")
        self.place, self.copy = place, copy

    def __enter__(self):
        units = self.builder.units_of(self.place["file"])
        self.compiled = bool(units) and all(self.compile(unit) for unit in units)
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)

    def compile(self, unit):
        changed = str(self.builder.source / self.place["file"]) == unit["file"]
        to = self.folder / f"{len(self.objects)}.o"
        words = [word for word in unit["words"]]
        source_at = words.index(unit["file"])
        words[source_at] = str(self.copy) if changed else unit["file"]
        words[words.index("-o") + 1] = str(to)
        prefix = self.builder.prefix_of(unit) if changed else None
        # a changed header lies in front of the tree's
        words[1:1] = ["-include", str(prefix)] if prefix else ["-I", str(self.folder)]
        done = subprocess.run(words, cwd=self.builder.folder, capture_output=True)
        self.objects.append((to, unit["output"]))
        return done.returncode == 0

    def link(self, program):
        """Returns the program with the changed objects in front of those that they replace."""
        to = self.folder / program
        words = list(self.builder.link_of(program))
        words[words.index("-o") + 1] = str(to)
        replaced = {output for _, output in self.objects}
        first = next(i for i, word in enumerate(words) if word.endswith(".o"))
        words = words[:first] + [str(path) for path, _ in self.objects] + [word for word in words[first:] if word not in replaced]
        done = subprocess.run(words, cwd=self.builder.folder, capture_output=True)
        return to if done.returncode == 0 else None


class Builder:
    """A build of the release preset, with little optimization of what is compiled for a fault."""

    def __init__(self, source, folder, work):
        self.source, self.folder, self.work = source, folder, work
        self.links, self.prefixes, self.lists, self.units = {}, {}, {}, {}

    def build(self, programs, jobs):
        hook = self.source / "tests/mutation/apart.cmake"
        subprocess.run(["cmake", "--preset", "release", "-B", self.folder, f"-DCMAKE_PROJECT_INCLUDE={hook}"], cwd=self.source,
                       check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ninja", f"-j{jobs}", "-C", self.folder, *sorted(programs)], check=True, stdout=subprocess.DEVNULL)
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir(parents=True)
        self.commands = []
        for entry in json.loads((self.folder / "compile_commands.json").read_text()):
            words = shlex.split(entry["command"])
            words = ["-O1" if re.fullmatch(r"-O[23]", word) else word for word in words if not word.startswith("-W")] + ["-w"]
            self.commands.append({"file": entry["file"], "output": words[words.index("-o") + 1], "words": words})
        self.needs = self.read_dependencies()

    def read_dependencies(self):
        """Returns the files that each object was compiled from."""
        needs, current = {}, None
        for line in output_of(["ninja", "-C", str(self.folder), "-t", "deps"]).splitlines():
            if line.startswith("    "):
                needs[current].add(line.strip())
            elif ": #deps" in line:
                current = line.split(":")[0]
                needs[current] = set()
        return needs

    def units_of(self, file):
        """Returns the compilations that see a file: its own, or for a header those of its library and of the tests beside."""
        if file not in self.units:
            path = str(self.source / file)
            if file.endswith(".cpp"):
                self.units[file] = [command for command in self.commands if command["file"] == path]
            else:
                tests = self.source / "tests" / pathlib.Path(file).parent
                its_test = tests / (pathlib.Path(file).stem + "_test.cpp")
                beside = (str((self.source / file).parent) + "/", str(its_test if its_test.exists() else tests))
                self.units[file] = [command for command in self.commands
                                    if command["file"].startswith(beside) and path in self.needs.get(command["output"], ())]
        return self.units[file]

    def prefix_of(self, unit):
        """Returns a header with all that a source includes, compiled once for all of the source's faults."""
        if unit["file"] not in self.prefixes:
            prefix = self.work / "prefixes" / str(len(self.prefixes)) / "prefix.h"
            prefix.parent.mkdir(parents=True, exist_ok=True)
            text = pathlib.Path(unit["file"]).read_text()
            prefix.write_text("\n".join(re.findall(r"^#include .*$", text, re.MULTILINE)) + "\n")
            words = [word for word in unit["words"]]
            words[words.index("-o") + 1] = str(prefix) + ".gch"
            words[words.index("-c"):] = ["-x", "c++-header", str(prefix)]
            done = subprocess.run(words, cwd=self.folder, capture_output=True)
            self.prefixes[unit["file"]] = prefix if done.returncode == 0 else None
        return self.prefixes[unit["file"]]

    def link_of(self, program):
        if program not in self.links:
            lines = output_of(["ninja", "-C", str(self.folder), "-t", "commands", f"bin/{program}"]).splitlines()
            command = next(line for line in reversed(lines) if f"-o bin/{program} " in line)
            words = shlex.split(command)
            words = words[words.index("&&") + 1:] if words[0] == ":" else words
            self.links[program] = words[: words.index("&&")] if "&&" in words else words
        return self.links[program]

    def tests_of(self, program):
        """Returns the names of a program's suites."""
        if program not in self.lists:
            lines = output_of([str(self.folder / "bin" / program), "--gtest_list_tests"], cwd=self.folder).splitlines()
            self.lists[program] = [line.split("#")[0].strip().rstrip(".") for line in lines if re.match(r"^\S+\.(\s|$)", line)]
        return self.lists[program]

    def run(self, command, program, seconds):
        """Returns the exit code of a test run; -1 if it took too long."""
        path = program or self.folder / "bin" / command[0]
        try:
            return subprocess.run([str(path), *command[1:], "--gtest_fail_fast"], cwd=self.folder, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, timeout=seconds).returncode
        except subprocess.TimeoutExpired:
            return -1
