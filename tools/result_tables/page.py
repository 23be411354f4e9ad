"""The tables of RESULTS.md: where each stands, and the stamp above it.

A table stands between <!-- results: NAME --> and <!-- end -->. Above it each stamp is one line:

  Measured: date 2026-11-27; commit 5a5a7d589948; machine AMD EPYC, 2 cores; command `tactus experiment ...`.

"Measured (ROWS):" is the stamp of those rows alone. What is not known is "not known", and such a line says "to be measured
again". A build of sources with changes that no commit has (-dirty) is no commit.
"""
import re

BLOCK = re.compile(r"(<!-- results: ([\w-]+) -->\n)(.*?)(<!-- end -->)", re.S)
STAMP = re.compile(r"Measured(?: \(([^)]+)\))?: date ([^;]+); commit ([^;]+); machine ([^;]+); command (.+)")
COMMIT = r"[0-9a-f]{7,40}"
HEAD_OF_TABLE = re.compile(r"^\|[ :|-]*-{3}[ :|-]*\|$", re.M)


def stamp(dates, commit, machine, command):
    first, last = min(dates), max(dates)
    date = first if first == last else f"{first} to {last}"
    return f"Measured: date {date}; commit {commit}; machine {machine}; command {command}."


def replaced(page, name, stamps, table):
    """The page with this table in its place; the text around it is kept. None: it has no place for it."""
    found = [match for match in BLOCK.finditer(page) if match[2] == name]
    if len(found) != 1:
        return None
    return page[:found[0].start(3)] + f"{stamps}\n\n{table}\n" + page[found[0].end(3):]


def faults(page, names):
    """What is wrong with the page, one line each: a table without a stamp, or that no name measures."""
    found = [(match[2], match[3]) for match in BLOCK.finditer(page)]
    there = [name for name, _ in found]
    lines = [f"{name}: no such table in tools/results" for name in there if name not in names]
    lines += [f"{name}: stands {there.count(name)} times on the page" for name in names if there.count(name) != 1]
    outside = BLOCK.sub("", page)
    lines += [f"a table between no marks: {outside[:m.start()].splitlines()[-1]}" for m in HEAD_OF_TABLE.finditer(outside)]
    for name, block in found:
        tables = len(HEAD_OF_TABLE.findall(block))
        if tables != 1:
            lines.append(f"{name}: {tables} tables between its marks")
        lines += [f"{name}: {fault}" for fault in stamp_faults(block)]
    return lines


def stamp_faults(block):
    stamped = [line for line in block.splitlines() if line.startswith("Measured")]
    if not stamped:
        return ["no line 'Measured: date ...; commit ...; machine ...; command ...'"]
    lines = []
    for line in stamped:
        match = STAMP.fullmatch(line)
        if not match:
            lines.append(f"no stamp: {line[:80]}")
            continue
        _, date, commit, machine, command = match.groups()
        if not re.fullmatch(r"(\d{4}-\d\d-\d\d( to \d{4}-\d\d-\d\d)?|not known)( \(.+\))?", date):
            lines.append(f"no date: {date}")
        if not re.match(rf"({COMMIT}|not known)([ ,].*)?$", commit):
            lines.append(f"no commit: {commit}")
        if not re.search(r"`[^`]+`|not known", command):
            lines.append(f"no command: {command}")
        if "not known" in line and "to be measured again" not in line:
            lines.append(f"not known, and not marked 'to be measured again': {line[:80]}")
    return lines
