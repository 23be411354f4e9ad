"""The page of `tactus experiment accuracy-cost`: the front of error and time, and what each change buys and costs."""
import html
import math
import string

from matplotlib import ticker

from pages import figure, theme
from pages.figure import tick_words
from pages.labels import label_points
from pages.numbers import count, exact, is_number, listed, micro, number, points, said, share, times, unit
from pages.page import Cell, Column
from pages.rows import NOTICED, unique

KEYS = [("sub_steps", "{} sub-steps"), ("relax_sweeps", "relax sweeps: {}"), ("friction_sweeps", "friction {}"),
        ("contact_Hz", "contacts {} Hz"), ("members", "{} members"), ("ratio", "ratio {}"), ("border", "border {}"),
        ("extraction", "{}"), ("world_precision", "world {}")]
CHEAPER = 0.05  # of a time: less is within what one run differs from the next


def setting_words(point, base=None):
    """All of a setting, or what differs from another."""
    words = [text.format(exact(point[key]) if isinstance(point[key], float) else point[key]) for key, text in KEYS
             if base is None or point[key] != base[key]]
    return ", ".join(words) or "the default"


class Scene:
    """The points of a scene that have an error and a time; the default first, the front by time."""

    def __init__(self, name, data):
        mine = [p for p in data["points"] if p["scene"] == name]
        self.name, self.default = name, next((p for p in mine if p["is_default"]), None)
        self.points = [p for p in mine if is_number(p["force_error_rms"]) and is_number(p["tick_us_p50"])]
        self.lost = len(mine) - len(self.points)
        self.front = sorted((p for p in self.points if p["on_front"]), key=lambda p: p["tick_us_p50"])
        self.names = dict(zip(map(id, self.front), letters(len(self.front))))
        self.notches = sorted((n for n in data["notches"] if n["scene"] == name), key=change_of_error)
        if self.default is not None and self.default not in self.points:
            self.default = None

    def halved(self):
        """The cheapest setting with at most half the default's error; none is there, or the default has none to halve."""
        wanted = [p for p in self.points if p["force_error_rms"] <= self.default["force_error_rms"] / 2]
        return min(wanted, key=lambda p: p["tick_us_p50"], default=None)


def letters(count_of):
    return [(string.ascii_uppercase[i // 26 - 1] if i >= 26 else "") + string.ascii_uppercase[i % 26] for i in range(count_of)]


def change_of_error(notch):
    change = notch["error_after"] - notch["error_before"] if is_number(notch["error_after"]) and is_number(
        notch["error_before"]) else math.inf
    return change


def span(items, write):
    """The least and the most of (value, scene), or the one."""
    low, high = min(items), max(items)
    words = lambda one: f"{write(one[0])} ({html.escape(one[1])})"
    return words(low) if len(items) == 1 or low[0] == high[0] else f"{words(low)} to {words(high)}"


def answer(scenes, data):
    known = [s for s in scenes if s.default]
    if not known:
        return "What accuracy costs is not known: no scene has a default setting with an error and a time."
    off = [s for s in known if s.default["force_error_rms"] > 0]
    costs = [(s.halved()["tick_us_p50"] - s.default["tick_us_p50"], s.name) for s in off if s.halved()]
    never = [html.escape(s.name) for s in off if not s.halved()]
    halving = []
    if costs:
        halving.append(f"changes the median tick by {span(costs, lambda v: micro(v) + ' µs')}"
                       + (f", on {len(costs)} of {len(known)} scenes," if len(costs) > 1 else ""))
    if never:
        halving.append(f"{'and ' if costs else ''}cannot be done by any measured setting on {listed(never)}")
    halving = " ".join(halving) or "has no meaning, for the default has no error"
    errors = span([(s.default["force_error_rms"], s.name) for s in known], said)
    takes = span([(s.default["tick_us_p50"], s.name) for s in known], lambda v: unit(v, "µs"))
    felt = [html.escape(s.name) for s in known if s.default["force_error_rms"] > NOTICED]
    noticed = (f"beyond the 7 % that a hand notices on {listed(felt)}" if felt else "on each scene below the 7 % that a hand "
               "notices" if len(known) > 1 else "below the 7 % that a hand notices")
    budget = f" of the {exact(data['budget_us'])} µs that a tick may compute" if is_number(data.get("budget_us")) else ""
    return (f"On this PC halving the default's force error {halving}; the default's median tick takes {takes}{budget}, for a force "
            f"that is off by {errors}, {noticed}.")


def sentences(scenes):
    lines = []
    for s in scenes:
        name = f"<b>{html.escape(s.name)}</b>"
        if not s.default or not s.front:
            lines.append(f"{name}: the default has no finite error or time; nothing can be said.")
            continue
        error, time = s.default["force_error_rms"], s.default["tick_us_p50"]
        within = [p for p in s.front if p["force_error_rms"] <= error]
        best, cheapest = min(s.front, key=lambda p: p["force_error_rms"]), min(within, key=lambda p: p["tick_us_p50"],
                                                                             default=s.default)
        words = (f"no setting as accurate is cheaper by {exact(100 * CHEAPER)} % or more"
                 if cheapest["tick_us_p50"] > (1 - CHEAPER) * time else
                 f"{s.names[id(cheapest)]} ({html.escape(setting_words(cheapest, s.default))}) is at least as accurate for "
                 f"{unit(cheapest['tick_us_p50'], 'µs')}")
        lines.append(f"{name}: the default's force is off by {said(error)} for a median tick of {unit(time, 'µs')}; {words}. The "
                     f"most accurate, {s.names[id(best)]} ({html.escape(setting_words(best, s.default))}), is off by "
                     f"{said(best['force_error_rms'])} and takes {unit(best['tick_us_p50'], 'µs')}.")
    return lines


def whiskers(panel, p, x, y, color):
    seeds = [100 * v for v in p.get("force_error_by_seed") or [] if is_number(v)]
    times = [v for v in p.get("tick_us_p50_by_seed") or [] if is_number(v)]
    at = x.place(p["tick_us_p50"])[0], y.place(100 * p["force_error_rms"])[0]
    if len(seeds) > 1:
        panel.axis.plot([at[0], at[0]], [y.place(min(seeds))[0], y.place(max(seeds))[0]], color=color, lw=0.9, alpha=0.6)
    if len(times) > 1:
        panel.axis.plot([x.place(min(times))[0], x.place(max(times))[0]], [at[1], at[1]], color=color, lw=0.9, alpha=0.6)


def front_figure(scenes, data, page):
    panels = []
    budget = [data["budget_us"]] if is_number(data.get("budget_us")) else []
    for s in scenes:
        panel = figure.Panel(s.name, "median tick [µs]", "force error [%]")
        shown = [p for p in s.points if p["on_front"] or p["is_default"]]  # those whose spread is drawn
        spread = lambda key: [v for p in shown for v in p.get(key) or []]
        x = figure.Scale([p["tick_us_p50"] for p in s.points] + spread("tick_us_p50_by_seed"), also=budget)
        y = figure.Scale([times(v, 100) for v in [p["force_error_rms"] for p in s.points] + spread("force_error_by_seed")],
                         floor=1e-3, cap=1000, also=[100 * NOTICED])
        x.apply(panel.axis, "x"), y.apply(panel.axis, "y")
        panel.line(100 * NOTICED, "7 %")
        for at in budget:
            panel.line(at, "budget", "v", (0, (6, 2, 1, 2)))
        off = [p for p in s.points if y.place(100 * p["force_error_rms"])[1] or x.place(p["tick_us_p50"])[1]]
        for p in off[:6]:
            panel.off_scale(setting_words(p, s.default), [f"{share(p['force_error_rms'])}, {unit(p['tick_us_p50'], 'µs')}"])
        if len(off) > 6:
            panel.note(f"Off the scale: {len(off) - 6} more.")
        if s.lost:
            panel.note(f"No finite error or time: {s.lost} settings.")
        at = lambda p: (x.place(p["tick_us_p50"])[0], y.place(100 * p["force_error_rms"])[0])
        rest = [p for p in s.points if not p["on_front"] and not p["is_default"]]
        inside = [p for p in rest if p not in off]
        if inside:
            panel.axis.plot(*zip(*map(at, inside)), ls="none", marker="o", ms=3.2, mfc="none", mec=theme.MUTE, mew=0.8)
        panel.beyond([at(p)[0] for p in rest if p in off], [at(p)[1] for p in rest if p in off], theme.MUTE)
        if s.front:
            for p in s.front:
                whiskers(panel, p, x, y, theme.SERIES[0])
            panel.axis.plot(*zip(*map(at, s.front)), marker="o", ms=4.5, lw=1.2, color=theme.SERIES[0], gid="series the front")
        if s.default:
            whiskers(panel, s.default, x, y, theme.SERIES[1])
            panel.axis.plot(*[[v] for v in at(s.default)], ls="none", marker="*", ms=10, mfc="none", mec=theme.SERIES[1], mew=1.3,
                            gid="series the default")
        marks = [(*at(p), 4 if p in off else 2) for p in rest] + ([(*at(s.default), 6)] if s.default else [])
        left = label_points(panel.axis, [(*at(p), s.names[id(p)]) for p in s.front], own=3, marks=marks)
        panel.note("; ".join(f"<b>{s.names[id(p)]}</b> " + html.escape(setting_words(p, s.default) if s.default else
                                                                     setting_words(p)) for p in s.front) or "No front.")
        if left:
            panel.note(f"No room for the letter of: {', '.join(left)}.")
        panels.append(panel.drawn(f"{page.title} front"))
    page.figure(panels, f"Every setting: left and below is better. The front: no other setting is as accurate and cheaper. Its points "
                "are named by what differs from the default. Bars: from the least to the most of "
                f"the hands (seeds: {data['seeds']}); none with one hand.",
                [(figure.key(theme.SERIES[0], "o", "-"), "the front"), (figure.key(theme.SERIES[1], "*", hollow=True), "the default"),
                 (figure.key(theme.MUTE, "o", hollow=True), "other settings"),
                 (figure.key(ls=figure.LIMIT_DASHES), "7 %: a hand notices"),
                 (figure.key(ls=(0, (6, 2, 1, 2))), "what a tick may compute")])


class SignedScale:
    """Both signs on a logarithmic axis, linear around zero."""

    def __init__(self, values, cap):
        sizes = sorted(abs(v) for v in values if is_number(v) and v != 0)
        inside = [v for v in sizes if v <= cap]
        middle = inside[len(inside) // 3] if inside else 1.0
        self.linear = 10 ** math.floor(math.log10(middle))
        good = [v for v in values if is_number(v) and abs(v) <= cap]
        self.low, self.high = (self.end(min(good + [0])), self.end(max(good + [0])))

    def end(self, value):
        return math.copysign(max(1.8 * abs(value), 1.5 * self.linear), value if value else -1)

    def place(self, value):
        return min(max(value, self.low), self.high), not self.low <= value <= self.high

    def apply(self, axis, which):
        (axis.set_xscale if which == "x" else axis.set_yscale)("symlog", linthresh=self.linear, linscale=0.8)
        (axis.set_xlim if which == "x" else axis.set_ylim)(self.low, self.high)
        powers = range(round(math.log10(self.linear)), round(math.log10(self.linear)) + 12)
        def chosen(every):
            up = [10.0 ** p for p in powers if (p - powers[0]) % every == 0]
            return [-v for v in reversed(up) if -v >= self.low] + [0] + [v for v in up if v <= self.high]
        ticks = next(t for t in map(chosen, range(1, 13)) if len(t) <= (6 if which == "x" else 9))
        line = axis.xaxis if which == "x" else axis.yaxis
        line.set_major_locator(ticker.FixedLocator(ticks))
        line.set_major_formatter(ticker.FixedFormatter(
            ["0" if t == 0 else ("+" if t > 0 else "−") + tick_words(abs(t)) for t in ticks]))
        line.set_minor_locator(ticker.NullLocator())


def notch_words(n):
    return f"{n['factor']} {n['from']} → {n['to']}"


def arrow_figure(scenes, data, page):
    factors = unique(n["factor"] for s in scenes for n in s.notches)
    look = {factor: theme.style(i) for i, factor in enumerate(factors)}
    panels = []
    for s in scenes:
        if not s.notches or not s.default:
            continue
        noticed = 100 * (NOTICED - s.default["force_error_rms"])
        budget = data["budget_us"] - s.default["tick_us_p50"] if is_number(data.get("budget_us")) else None
        changes = [(n, n["tick_us_after"] - n["tick_us_before"], 100 * change_of_error(n)) if all(
            is_number(n[k]) for k in ("tick_us_after", "tick_us_before", "error_after", "error_before")) else (n, None, None)
            for n in s.notches]
        x = SignedScale([dx for _, dx, _ in changes] + [budget], 1e5)
        y = SignedScale([dy for _, _, dy in changes] + [noticed], 1000)
        panel = figure.Panel(s.name, "change of the median tick [µs]", "change of the error [% points]")
        x.apply(panel.axis, "x"), y.apply(panel.axis, "y")
        panel.axis.axhline(0, color=theme.MUTE, lw=0.6), panel.axis.axvline(0, color=theme.MUTE, lw=0.6)
        panel.line(noticed, "7 %")
        if budget is not None:
            panel.line(budget, "budget", "v", (0, (6, 2, 1, 2)))
        labelled, off = [], []
        for i, (n, dx, dy) in enumerate(changes, 1):
            if dx is None:
                panel.note(f"No finite number: {i}, {html.escape(notch_words(n))}.")
                continue
            (at_x, off_x), (at_y, off_y) = x.place(dx), y.place(dy)
            if off_x or off_y:
                off.append(f"{i}: {points(dy / 100)}, {micro(dx)} µs")
            own = look[n["factor"]]
            panel.axis.annotate("", xy=(at_x, at_y), xytext=(0, 0), annotation_clip=False, arrowprops={
                "arrowstyle": "-|>,head_width=0.2,head_length=0.4", "color": own["color"], "lw": 1.1, "ls": own["ls"],
                "shrinkA": 0, "shrinkB": 0})
            labelled.append((at_x, at_y, str(i)))
        if off:
            panel.note(f"Off the scale, {'; '.join(off)}.")
        left = label_points(panel.axis, labelled)
        if left:
            panel.note(f"No room for the number of: {', '.join(left)}.")
        panels.append(panel.drawn(f"{page.title} arrows"))
    if panels:
        page.figure(panels, "From the default (0, 0), one factor changed: an arrow down saves error, one to the left saves time. "
                    "Numbers: rows of the table below. Both axes are logarithmic, linear around zero.",
                    [(figure.key(look[f]["color"], None, look[f]["ls"]), f) for f in factors]
                    + [(figure.key(ls=figure.LIMIT_DASHES), "the error reaches 7 %: a hand notices"),
                       (figure.key(ls=(0, (6, 2, 1, 2))), "the tick reaches what it may compute")])
    return look


def notch_table(scenes, data, page, look):
    page.text("Sorted by what they do to the error, what saves most first. The global world's time is that of its step over the "
              "ratio. Changes of some µs are within what one run differs from the next.")
    budget = data.get("budget_us")
    def time(us):
        over = is_number(budget) and is_number(us) and us > budget
        return Cell(number(us) + (", over" if over else ""), "bad" if over else "")
    def error(value):
        felt = not is_number(value) or value > NOTICED
        return Cell(share(value), "bad" if felt else "")
    def change(after, before):
        return micro(after - before) if is_number(after) and is_number(before) else "n/a"
    rows = []
    for s in scenes:
        for i, n in enumerate(s.notches, 1):
            own = look.get(n["factor"], theme.style(0))
            rows.append([s.name, i, Cell(figure.key(own["color"], None, own["ls"]) + " " + html.escape(n["factor"])),
                         f"{n['from']} → {n['to']}", points(change_of_error(n)) if math.isfinite(change_of_error(n)) else "n/a",
                         error(n["error_after"]), change(n["tick_us_after"], n["tick_us_before"]), time(n["tick_us_after"]),
                         change(n["global_us_after"], n["global_us_before"])])
    page.table([Column("scene", "the world", "t"), Column("#", "the arrow's number"), Column("factor", "what is changed, alone", "t"),
                Column("change", "from the default to", "t"), Column("error by", "percentage points of the force"),
                Column("error then", "of the force; red: beyond the 7 % that a hand notices"),
                Column("tick by", "the median, µs"), Column("tick then", "the median, µs; red: over what a tick may compute"),
                Column("global by", "time of the global world for each tick, µs")], rows)


def front_table(scenes, page):
    rows = []
    for s in scenes:
        shown = s.front + ([s.default] if s.default and not s.default["on_front"] else [])
        for p in sorted(shown, key=lambda p: p["tick_us_p50"]):
            seeds = [v for v in p.get("force_error_by_seed") or [] if is_number(v)]
            rows.append([s.name, s.names.get(id(p), "–") + (" (default)" if p["is_default"] else ""), setting_words(p),
                         share(p["force_error_rms"]), f"{share(min(seeds))} … {share(max(seeds))}" if seeds else "–",
                         unit(p["hold_vibration_N"], "N"), unit(p["sync_step_N"], "N"), number(p["tick_us_p50"]),
                         number(p["tick_us_p99"]), count(p["instructions"]) if is_number(p["instructions"]) else "–"])
    page.table([Column("scene", "the world", "t"), Column("name", "in the figure; –: not on the front", "t"),
                Column("setting", "all of it", "w"), Column("force error", "RMS(F − F_ref) / RMS(F_ref), over all windows"),
                Column("by hand", "least and most of the seeds"), Column("vibration", "20 to 500 Hz while the hand holds"),
                Column("sync step", "95 % of the steps at synchronisations are smaller"),
                Column("tick p50", "half of the ticks take longer, µs"), Column("tick p99", "one of 100 does, µs"),
                Column("instructions", "of a tick; –: not counted")], rows)


def cost_page(data, page, what):
    scenes = [Scene(name, data) for name in unique(p["scene"] for p in data["points"])]
    page.answer(answer(scenes, data))
    page.findings(sentences(scenes))
    page.text(f"Hands: {data['seeds']}. Each point is a setting of solver, sub-world and border, on windows of 25 cycles, at least "
              "200 ms, against a run of all bodies at 1 kHz with 16 sub-steps and two relax sweeps: its error is the solver's and the "
              "coupling's, the same on any machine. Time is what a tick computes on the haptic side, CPU time of one thread on this "
              "machine.")
    page.head("The front of accuracy and time")
    front_figure(scenes, data, page)
    page.head("What each change buys, and what it costs")
    look = arrow_figure(scenes, data, page)
    notch_table(scenes, data, page, look)
    page.head("The front, setting by setting")
    front_table(scenes, page)
