"""A table is measured in parts. Each is kept in build/results/TABLE/ when it is done, and is not measured again by the same
command as long as the programs, the scenes and the machine are the same: after an interruption the command goes on.
"""
import dataclasses
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time
from typing import Callable

from result_tables.words import duration

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
KEPT = ROOT / "build/results"


class Failed(Exception):
    """One line: what could not be measured, and what to do."""


@dataclasses.dataclass(frozen=True)
class Part:
    name: str  # of its file, and in the progress
    words: tuple  # the command: a program, then its arguments
    minutes: float  # roughly, on one core of the machine that the page names; weighs the progress
    measure: Callable  # (part, bench) -> what is kept, as JSON
    revision: str = ""  # whose build is measured; empty: this checkout's


@dataclasses.dataclass(frozen=True)
class Done:
    part: Part
    data: dict
    date: str


@dataclasses.dataclass(frozen=True)
class Table:
    command: str  # as the stamp shows it, in backticks where it is a command
    takes: str  # how long, for --help
    parts: Callable  # (base) -> list of Part
    rows: Callable  # (list of Done) -> the table; some parts may be missing
    base: str = ""  # the git revision that it is compared with; empty: with none


class Bench:
    """What measures: the build folder, and folders of other revisions' builds (builds.py)."""

    def __init__(self, build, workers=0, build_of=None):
        self.build, self.workers, self.build_of = pathlib.Path(build).resolve(), workers, build_of
        self.folder = KEPT
        self.digests = {}

    def folder_of(self, part):
        return self.build_of(part.revision) if part.revision else self.build

    def program(self, part, name="tactus"):
        return self.folder_of(part) / "tools" / name

    def commit(self):
        version = subprocess.run([self.build / "tools/tactus", "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
        found = re.search(r"\(commit (\S+)\)", version)
        return found[1] if found else f"not known ({version.splitlines()[0]}), to be measured again"

    def digest(self, path):
        path = pathlib.Path(path)
        if path not in self.digests:
            self.digests[path] = hashlib.sha256(path.read_bytes()).hexdigest()
        return self.digests[path]

    def identity(self, part):
        """Equal if and only if the part would be the same measurement."""
        measured = part.revision or {name: self.digest(self.build / "tools" / name) for name in ("tactus", "bench_counted_steps")
                                     if (self.build / "tools" / name).exists()}
        scenes = {ROOT / word for word in part.words if word.endswith(".toml")}
        files = {file for scene in scenes for file in [scene, *sorted(scene.parent.glob("shapes/*"))] if file.is_file()}
        return {"words": list(part.words), "program": measured, "machine": machine(),
                "files": {str(file.relative_to(ROOT)): self.digest(file) for file in sorted(files)}}


def machine():
    names = re.findall(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.M)
    return f"{names[0] if names else 'of an unknown CPU'}, {len(names) or os.cpu_count()} cores"


def absolute(word):
    """A scene of this checkout by its whole path: a part runs in a folder of its own, for what it writes beside its result."""
    return str(ROOT / word) if word.endswith(".toml") else word


def run_json(part, bench):
    """What `tactus ... --json` prints. An exit status that is not 0 is a verdict, not a failure, if there is an object."""
    spread = part.words[1] == "experiment" and part.words[2] in ("energy-loss", "hard-cases")
    workers = ["--workers", str(bench.workers)] if bench.workers and spread else []
    command = [bench.program(part), *map(absolute, part.words[1:]), *workers, "--json"]
    done = subprocess.run(command, cwd=bench.folder, stdout=subprocess.PIPE, text=True, check=False)
    try:
        result = json.loads(done.stdout)
    except json.JSONDecodeError:
        raise Failed(f"{' '.join(part.words)}: ended with status {done.returncode} and without a JSON object") from None
    if "error" in result:
        raise Failed(f"{' '.join(part.words)}: {result['error']}")
    return result


def write(path, text):
    """At once or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".new")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def kept(path, identity):
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        return None
    return record if record.get("identity") == identity else None


def measured(name, parts, bench, each):
    """Measures the parts that are not kept; calls each(list of Done) after every one. Returns all."""
    bench.folder = KEPT / name
    bench.folder.mkdir(parents=True, exist_ok=True)
    done, spent_s, spent_minutes = [], 0.0, 0.0
    for at, part in enumerate(parts):
        path = bench.folder / f"{part.name}.json"
        identity = bench.identity(part)
        record = kept(path, identity)
        if record is None:
            left = sum(p.minutes for p in parts[at:])
            # A minute of the estimate is what it has turned out to be in this run.
            pace = spent_s / spent_minutes if spent_minutes else 60.0
            share = 100 * (1 - left / sum(p.minutes for p in parts))
            print(f"{name}: part {at + 1} of {len(parts)}, {share:.0f} %, about {duration(left * pace)} left: {' '.join(part.words)}",
                  file=sys.stderr, flush=True)
            start = time.monotonic()
            record = {"identity": identity, "date": datetime.date.today().isoformat(), "data": part.measure(part, bench)}
            record["seconds"] = time.monotonic() - start
            spent_s, spent_minutes = spent_s + record["seconds"], spent_minutes + part.minutes
            write(path, json.dumps(record, indent=1) + "\n")
        done.append(Done(part, record["data"], record["date"]))
        each(done)
    return done
