"""What the pages say of rows of figures: the worst, its scene, names of couplings."""
import html
import math

from pages.numbers import at_most, is_number, share, unit

NOTICED = 0.07  # of a force: the difference that a hand just notices (Pang, Tan, Durlach 1991)


def unique(values):
    return list(dict.fromkeys(values))


def worst(rows, key):
    """The row with the largest finite value; no number at all is worse."""
    return max(rows, key=lambda r: r[key] if is_number(r[key]) else math.inf, default=None)


def worst_words(rows, key, write=share, bound=False):
    """The worst value and its scene; in a sentence with "at most" before it."""
    row = worst(rows, key)
    if not row:
        return "not measured"
    if bound and row[key] == 0:
        return "none"
    return f"{at_most(row[key], write) if bound else write(row[key])} ({html.escape(row['scene'])})"


def name_of(row, several):
    """"sub-world (ghost)"; with the cap on members where several ran."""
    more = [row["border"]] * (row["border"] != "-") + [f"{row['members']} members"] * several
    return row["coupling"] + (f" ({', '.join(more)})" if more else "")


def newton(value):
    return unit(value, "N")
