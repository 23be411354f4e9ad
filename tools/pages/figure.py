"""Panels, their axes and legends: the rules that all figures follow.

A logarithmic axis has three to eight ticks, written as numbers. What lies below its least lies on its lower edge, whose
tick then says "≤"; what lies beyond its most is a hollow triangle at the edge and a note below the panel.
"""
import html
import math

import matplotlib.pyplot as plt
from matplotlib import ticker

from pages import numbers, theme

WIDTH, HEIGHT = 3.54, 2.7  # inches: 340 px of a page, so that a narrow window shows text as large as a wide one
FAR = 3000  # times the median: a value beyond is off the scale
SPREAD = 0.8  # of the room of a step of a stepped axis, shared by its series


def tick_words(value):
    exponent = math.floor(math.log10(value) + 1e-9)
    lead = value / 10 ** exponent
    if -4 < exponent < 5:
        return numbers.exact(value)
    return numbers.power_of_ten(exponent) if abs(lead - 1) < 1e-6 else f"{lead:g}·{numbers.power_of_ten(exponent)}"


def log_ticks(low, high, most=7):
    """Where a logarithmic axis has its ticks: as dense as `most` allows."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    def inside(leads, every=1):
        return [lead * 10.0 ** e for e in range(first, last + 1) if e % every == 0 for lead in leads
                if low * (1 - 1e-9) <= lead * 10.0 ** e <= high * (1 + 1e-9)]
    choices = [inside(leads) for leads in ((1, 1.5, 2, 3, 4, 5, 6, 8), (1, 1.5, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,))]
    choices += [inside((1,), every) for every in (2, 3, 4, 5, 10)]
    return next((ticks for ticks in choices if len(ticks) <= most), choices[-1])


class Scale:
    """A logarithmic axis for some values: its ends, and where each value is drawn."""

    def __init__(self, values, floor=None, cap=None, also=(), far=FAR):
        good = sorted(v for v in values if numbers.is_number(v) and v > 0)
        middle = good[len(good) // 2] if good else 1.0
        shown = [v for v in good if v <= min(cap or math.inf, far * middle) and (floor is None or v >= floor)]
        shown += [v for v in also if numbers.is_number(v) and v > 0] or ([] if shown else [floor or middle])
        low, high = min(shown), max(shown)
        if floor is not None and any(numbers.is_number(v) and v < floor for v in values):
            low = floor
        elif any(numbers.is_number(v) and v <= 0 for v in values):
            low = low / 3
            floor = low
        self.has_floor = floor is not None and any(numbers.is_number(v) and v < floor for v in values)
        self.least, self.most = low, high
        if high < 5 * low:
            middle = math.sqrt(low * high)
            low, high = min(low, middle / 2.3), max(high, middle * 2.3)
        room = (high / low) ** 0.06
        self.low, self.high = low / room, high * room

    def place(self, value):
        """(where it is drawn, whether it is off the scale); nowhere for what is no number."""
        if not numbers.is_number(value):
            return None, False
        if value < self.least:
            return self.least, False
        return (self.high / (self.high / self.low) ** 0.03, True) if value > self.high else (value, False)

    def apply(self, axis, which):
        (axis.set_xscale if which == "x" else axis.set_yscale)("log")
        (axis.set_xlim if which == "x" else axis.set_ylim)(self.low, self.high)
        line = axis.xaxis if which == "x" else axis.yaxis
        ticks = log_ticks(self.low, self.high, 6 if which == "x" else 8)
        words = [tick_words(t) for t in ticks]
        if self.has_floor:
            far = (self.high / self.low) ** 0.07
            ticks = [self.least] + [t for t in ticks if t > self.least * far]
            words = ["≤ " + tick_words(self.least)] + [tick_words(t) for t in ticks[1:]]
        line.set_major_locator(ticker.FixedLocator(ticks))
        line.set_major_formatter(ticker.FixedFormatter(words))
        line.set_minor_locator(ticker.NullLocator())


def plain_axis(axis, which, low, high):
    """A linear axis with four to six ticks."""
    (axis.set_xlim if which == "x" else axis.set_ylim)(low, high)
    line = axis.xaxis if which == "x" else axis.yaxis
    line.set_major_locator(ticker.MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10]))
    line.set_major_formatter(ticker.FuncFormatter(lambda v, _: numbers.grouped(f"{v:.6g}")))


class Panel:
    """One drawing. Notes stand below it."""

    def __init__(self, title, x_label, y_label):
        self.title, self.notes = title, []
        self.fig, self.axis = plt.subplots(figsize=(WIDTH, HEIGHT))
        self.fig.subplots_adjust(left=0.21, right=0.945, bottom=0.18, top=0.9)
        self.axis.set_title(title if len(title) <= 34 else title[:33] + "…")
        self.axis.set_xlabel(x_label)
        self.axis.set_ylabel(y_label)
        self.axis.yaxis.set_label_coords(0.045, 0.54, transform=self.fig.transFigure)  # the same whatever the ticks say

    def note(self, markup):
        self.notes.append(markup)

    def off_scale(self, series, words):
        """Says what is beyond the axis, a note for each series."""
        if words:
            self.note(f"Off the scale, {html.escape(series)}: {html.escape(', '.join(words))}.")

    def beyond(self, xs, ys, color):
        """Marks of what is off the scale, at its edge."""
        if xs:
            self.axis.plot(xs, ys, ls="none", marker="^", ms=6.5, mfc="none", mec=color)

    def line(self, at, name, which="h", ls=(0, (4, 3))):
        """A limit, where the axis reaches it."""
        draw = self.axis.axhline if which == "h" else self.axis.axvline
        draw(at, color=theme.MUTE, lw=1, ls=ls, zorder=1.5, gid=f"limit {name}")

    def drawn(self, salt):
        return theme.svg_of(self.fig, f"{salt} {self.title}", html.escape(self.title)), self.notes


def stepped(panel, steps, series, scale, words, index_of):
    """Series over a few steps, such as ratios, side by side within a step: none hides another, though they be equal.

    series: name -> {step: (value, least, most, flagged)}; least and most of the spread, or nothing; `words` writes a value;
    `index_of`: the place of a series among all of the figure's."""
    axis, room = panel.axis, SPREAD / max(1, len(index_of))
    size = 5.5 if len(index_of) <= 6 else 4 if len(index_of) <= 10 else 3
    scale.apply(axis, "y")
    for name, by_step in series.items():
        look = theme.style(index_of[name])
        off, lost, xs, ys = [], [], [], []
        for i, step in enumerate(steps):
            if step not in by_step:
                continue
            value, least, most, flagged = by_step[step]
            x = i + (index_of[name] + 0.5) * room - SPREAD / 2
            y, beyond = scale.place(value)
            if y is None:
                lost.append(str(step))
                continue
            if beyond:
                off.append(f"{words(value)} at {step}")
                panel.beyond([x], [y], look["color"])
            else:
                if least is not None and most is not None and most > least:
                    low, high = scale.place(least)[0], scale.place(most)[0]
                    if low is not None and high is not None:
                        axis.plot([x, x], [low, high], color=look["color"], lw=1, alpha=0.75, solid_capstyle="butt")
                axis.plot([x], [y], ls="none", marker=look["marker"], ms=size, mfc=look["color"], mec="none")
            if flagged:
                axis.plot([x], [y], ls="none", marker="x", ms=size + 3, mew=1.2, color=theme.INK)
            xs.append(x), ys.append(y)
        axis.plot(xs, ys, color=look["color"], ls=look["ls"], lw=0.9, alpha=0.6, gid=f"series {html.escape(name)}")
        panel.off_scale(name, off)
        if lost:
            panel.note(f"No finite number: {html.escape(name)} at {', '.join(lost)}.")
    axis.set_xlim(-0.5, len(steps) - 0.5)
    every = max(1, -(-len(steps) // 8))
    axis.xaxis.set_major_locator(ticker.FixedLocator(range(0, len(steps), every)))
    axis.xaxis.set_major_formatter(ticker.FixedFormatter([str(s) for s in steps[::every]]))
    axis.grid(False, axis="x")
    for i in range(1, len(steps)):
        axis.axvline(i - 0.5, color=theme.GRID, lw=0.8, zorder=0.5)


def coincident(curves):
    """Names of the curves that lie on one another, {name: the first of them}: [(x, y), ...] by name."""
    same = {}
    for name, points in curves.items():
        for other, theirs in curves.items():
            if other == name:
                break
            if points and len(points) == len(theirs) and all(
                    math.isclose(a, b, rel_tol=1e-3, abs_tol=1e-15) for p, q in zip(points, theirs) for a, b in zip(p, q)):
                same[name] = other
                break
    return same


MARK_PATHS = {"o": '<circle cx="17" cy="7" r="4"/>', "s": '<rect x="13.5" y="3.5" width="7" height="7"/>',
              "^": '<path d="M17 2.5l4.5 8h-9z"/>', "v": '<path d="M17 11.5l4.5-8h-9z"/>',
              "D": '<path d="M17 2l5 5-5 5-5-5z"/>', "P": '<path d="M15 2h4v3h3v4h-3v3h-4v-3h-3v-4h3z"/>',
              "X": '<path d="M14.5 2L17 4.5 19.5 2 22 4.5 19.5 7 22 9.5 19.5 12 17 9.5 14.5 12 12 9.5 14.5 7 12 4.5z"/>',
              "x": '<path d="M12.5 2.5l9 9m0-9l-9 9" fill="none" stroke-width="1.6"/>',
              "*": '<path d="M17 1l1.5 4.2 4.5.1-3.6 2.7 1.3 4.3-3.7-2.6-3.7 2.6 1.3-4.3L11 5.3l4.5-.1z"/>'}


def key(color=theme.MUTE, marker=None, ls=None, hollow=False):
    """A legend's sample of a line, a mark, or both."""
    name = f"var(--{theme.VARIABLE[color]})"
    line = ""
    if ls is not None:
        dashes = "" if ls == "-" else f' stroke-dasharray="{" ".join(str(1.6 * d) for d in ls[1])}"'
        line = f'<path d="M1 7H33" stroke-width="1.6" fill="none"{dashes}/>'
    mark = MARK_PATHS[marker] if marker else ""
    return (f'<svg width="34" height="14" viewBox="0 0 34 14" aria-hidden="true" fill="{"none" if hollow else name}" '
            f'stroke="{name}" stroke-width="{1.2 if hollow else 0.6}">{line}{mark}</svg>')


def series_keys(names):
    return [(key(**theme.style(i)), name) for i, name in enumerate(names)]


LIMIT_DASHES = (0, (4, 3))
FLOOR_DASHES = (0, (1, 2))
