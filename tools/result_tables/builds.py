"""Builds of other revisions, for tables that compare with one: from git's archive, with this checkout's compiler and preset.

A revision without tools/bench/counted_steps.cpp gets this checkout's: its engine, its scenes and its settings are its own.
"""
import shutil
import subprocess
import sys

from result_tables.parts import KEPT, ROOT, Failed

COUNTED = "bench/counted_steps.cpp"
TARGET = """
add_executable(bench_counted_steps bench/counted_steps.cpp)
target_link_libraries(bench_counted_steps PRIVATE tactus_experiment)
"""


def git(*words):
    return subprocess.run(["git", *words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)


def commit_of(revision):
    found = git("rev-parse", "--verify", "--quiet", revision + "^{commit}")
    if found.returncode:
        raise Failed(f"{revision} is no revision of this repository")
    return found.stdout.strip()


def unpack(commit, source):
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    with subprocess.Popen(["git", "archive", commit], cwd=ROOT, stdout=subprocess.PIPE) as archive:
        unpacked = subprocess.run(["tar", "-x", "-C", source], stdin=archive.stdout, check=False)
    if archive.returncode or unpacked.returncode:
        raise Failed(f"git archive {commit[:12]} could not be unpacked in {source}")
    if not (source / "tools" / COUNTED).exists():
        (source / "tools/bench").mkdir(exist_ok=True)
        shutil.copy(ROOT / "tools" / COUNTED, source / "tools" / COUNTED)
        with open(source / "tools/CMakeLists.txt", "a", encoding="utf-8") as file:
            file.write(TARGET)


def build_of(revision):
    """The build folder of a revision; built if it is not there."""
    commit = commit_of(revision)
    source = KEPT / f"source-{commit[:12]}"
    build = source / "build/release"
    complete = source / "built"
    if complete.exists():
        return build
    unpack(commit, source)
    print(f"building {revision} in {source.relative_to(ROOT)}: some minutes", file=sys.stderr, flush=True)
    for words in (["cmake", "--preset", "release"], ["cmake", "--build", "build/release", "--target", "tactus", "bench_counted_steps"]):
        done = subprocess.run(words, cwd=source, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode:
            raise Failed(f"{revision}: `{' '.join(words)}` in {source} ended with status {done.returncode}: "
                         f"{(done.stdout.splitlines() or ['nothing printed'])[-1]}")
    complete.touch()
    return build
