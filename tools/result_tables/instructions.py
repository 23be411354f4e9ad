"""Instructions, counted by valgrind's callgrind, beside those of another revision. A count depends on the build alone."""
import json
import re
import shutil
import subprocess
import sys

from result_tables.parts import ROOT, Failed, Part, Table, absolute
from result_tables.words import markdown, three

COMPARED = {"tick-instructions": "a2cf87a", "step-instructions": "f2a9163"}  # the border without a buffer; before the cures


def valgrind():
    if not shutil.which("valgrind"):
        raise Failed("no valgrind (Debian: valgrind)")


def compared(done):
    """By name of the part: (now, base), base None where there is none."""
    now = {one.part.name: one.data for one in done if not one.part.revision}
    base = {one.part.name.removesuffix("-before"): one.data for one in done if one.part.revision}
    return {name: (data, base.get(name)) for name, data in now.items()}


# --- a tick with a border

TICK_SCENES = {"stack20": 10, "card_house": 12, "press": 16, "peg_in_shaft": 8, "chain": 8, "wall": 30, "pile250": 64}
TICK = "tactus run sim/scenes/{scene}.toml --virtual-time --duration 1.2 --ratio 8 --members {members}"
TICK_PARTS = r"SubWorld::(step|synchronise)\((?!.*\.cold)"
OF_GLOBAL_STEP = r"SubWorldPrediction::"  # calls the same functions, on the global world's core


def inclusive(path, pattern, but_from):
    """Instructions of the functions that match `pattern`, with what they call, without the calls from functions that
    match `but_from`. A call is one line of its caller's block."""
    names, total, called, block, callee = {}, {}, {}, None, None
    with open(path, encoding="utf-8") as file:
        for line in file:
            if match := re.match(r"(c?)fn=\((\d+)\)(?: (.*))?", line):
                if match[3]:
                    names[match[2]] = match[3].strip()
                if match[1]:
                    callee = match[2]
                else:
                    block, callee = match[2], None
            elif block and (match := re.match(r"[+\-*]?\d* (\d+)$", line)):
                total[block] = total.get(block, 0) + int(match[1])
                if callee:
                    called[block, callee] = called.get((block, callee), 0) + int(match[1])
                    callee = None
            elif line.startswith(("summary:", "totals:")):
                block = None
    all_calls = sum(count for at, count in total.items() if re.search(pattern, names[at]))
    return all_calls - sum(count for (by, at), count in called.items() if re.search(pattern, names[at]) and re.search(but_from, names[by]))


def lacking(part, why):
    """Of a base a row that it refuses is {}; of this checkout it is an error."""
    if not part.revision:
        raise Failed(f"{' '.join(part.words)}: {why}")
    print(f"commit {part.revision} has no figure for {' '.join(part.words)}: {why}", file=sys.stderr)
    return {}


def count_tick(part, bench):
    valgrind()
    out = bench.folder / f"{part.name}.callgrind"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", bench.program(part), *map(absolute, part.words[1:])]
    run = subprocess.run(command, cwd=bench.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    instructions = inclusive(out, TICK_PARTS, OF_GLOBAL_STEP) if out.exists() else 0
    out.unlink(missing_ok=True)
    if not instructions:  # a run's exit status is a verdict: it does not say that nothing was counted
        said = [line for line in run.stderr.splitlines() if not line.startswith("==")]  # valgrind's own lines
        return lacking(part, said[-1] if said else f"exit status {run.returncode}")
    return {"instructions": instructions}


def tick_parts(base):
    parts = []
    for scene, members in TICK_SCENES.items():
        words, minutes = tuple(TICK.format(scene=scene, members=members).split()), 1 if scene in ("press", "wall", "pile250") else 0.1
        parts += [Part(scene, words, minutes, count_tick), Part(f"{scene}-before", words, minutes, count_tick, base)]
    return parts


def tick_instructions(done):
    rows = []
    for scene, (now, base) in compared(done).items():
        millions = now["instructions"] / 1e6
        before = base["instructions"] / 1e6 if base else None
        rows.append([f"{scene}, {TICK_SCENES[scene]}", f"{before:.1f}" if before else "-", f"{millions:.1f}",
                     f"{millions / before:.3f}" if before else "-"])
    return markdown(["scene, members", "before", "now", "ratio"], rows)


# --- a step, row by row

# Millions of instructions by the engine of commit e8bd088 with the scenes and settings of 2026-11-27, recorded in commit
# 8e0e693. Its own scenes lack some rows and its contacts were softer, so that no build of it gives these figures again.
STUDY = {"pile64-stirred": 0.86, "pile1000": 6.51, "pile1000-stirred": 34.5, "hulls1000-8-stirred": 55.6, "hulls1000": 32.9,
         "hulls1000-stirred": 74.7, "hulls1000-64-stirred": 127.7, "shapes1000": 21.1, "shapes1000-stirred": 34.5, "terrain1000": 154.4}
STEP_MINUTES = {"pile5000-stirred": 2.5, "pile10000-stirred": 5}  # else 0.7
COUNT = "tools/bench/step_instructions"


def count_step(part, bench):
    valgrind()
    out = bench.folder / f"{part.name}.counted"
    command = [ROOT / COUNT, "--build", bench.folder_of(part), "--json", out, part.words[-1]]
    run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode:
        return lacking(part, (run.stderr.splitlines() or [f"exit status {run.returncode}"])[-1])
    row = json.loads(out.read_text(encoding="utf-8"))["rows"][0]
    out.unlink()
    return {"points": row["points"], "instructions": row["instructions"]}


def step_parts(base):
    parts = []
    for row in (*STUDY, *STEP_MINUTES):
        words, minutes = (COUNT, row), STEP_MINUTES.get(row, 0.7)
        parts += [Part(row, words, minutes, count_step), Part(f"{row}-before", words, minutes, count_step, base)]
    return parts


def millions_of(count):
    value = count / 1e6
    return f"{value:.2f}" if value < 9.995 else f"{value:.1f}"


def step_instructions(done):
    rows = []
    for row, (now, base) in compared(done).items():
        study = STUDY.get(row)
        rows.append([f"`{row}`", f"{now['points']:,.0f}", f"{study:g}" if study else "-", millions_of(base["instructions"]) if base else "-",
                     millions_of(now["instructions"]), three(now["instructions"] / 1e6 / study) if study else "-"])
    return markdown(["row", "points", "study", "before", "now", "now / study"], rows)


TABLES = {
    "tick-instructions": Table(f"`valgrind --tool=callgrind {TICK.format(scene='SCENE', members='MEMBERS')}`",
                               "7 min, and the build of the base", tick_parts, tick_instructions, COMPARED["tick-instructions"]),
    "step-instructions": Table(f"`{COUNT} ROW`, row by row", "30 min, and the build of the base", step_parts, step_instructions,
                               COMPARED["step-instructions"]),
}
