"""The sizes of the sources, then and now: tools/source_figures."""
import subprocess

from result_tables.parts import ROOT, Part, Table

COUNT = "tools/source_figures"
BASE = "ecf91baa"  # as the sources were when their design was reviewed
MINUTES = 0.2


def count(part, bench):
    now = bench.commit()
    revisions = part.words[1:] if now.endswith("-dirty") else [*part.words[1:], now]
    return {"table": subprocess.run([ROOT / COUNT, *revisions], check=True, stdout=subprocess.PIPE, text=True).stdout.strip()}


def parts(base):
    return [Part("figures", (COUNT, base), MINUTES, count)]


def rows(done):
    return done[0].data["table"]


TABLES = {"sources": Table(f"`{COUNT} BEFORE NOW`", "10 s", parts, rows, BASE)}
