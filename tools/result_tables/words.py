"""Numbers and tables as RESULTS.md has them."""


def percent(share):
    """Two digits, and no more than a reader needs: 0.33 %, 7.3 %, 85 %, > 1000 %."""
    value = 100 * share
    if value > 1000:
        return "> 1000 %"
    return f"{value:.0f} %" if value >= 9.95 else f"{value:.1f} %" if value >= 0.995 else f"{value:.2f} %"


def digits(value):
    """0, 0.59, 7.3, 15.9."""
    return "0" if value == 0 else f"{value:.2f}" if value < 0.995 else f"{value:.1f}"


def three(value):
    """Three digits of a ratio: 0.087, 0.36, 1.21."""
    return f"{value:.3f}" if value < 0.0995 else f"{value:.2f}"


def overlap_mm(metres):
    """0.045, 0.39, 1.20, 12."""
    value = 1e3 * metres
    return f"{value:.0f}" if value >= 9.95 else f"{value:.1f}" if value >= 1.995 else three(value)


def markdown(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def duration(seconds):
    """At least a minute is said in minutes, at least 100 minutes in hours."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
