"""The page of `energy-loss` and `couplings`: windows, whole runs, and what they say."""
import html
import math
from dataclasses import dataclass
from typing import Callable

from pages import figure, theme
from pages.numbers import count, exact, is_number, listed, number, share, times
from pages.page import Cell, Column
from pages.rows import NOTICED, name_of, newton, unique, worst, worst_words
from pages.whole_runs import whole_runs, whole_sentences

OURS = "ghost"  # the border that ships: targets are its alone
TARGETS = [(8, "loss", 0.01, "energy lost"), (8, "gain", 0.001, "energy gained"), (16, "loss", 0.02, "energy lost"),
           (8, "force_error_rms", 0.05, "force error"), (8, "hold_vibration_N", 0.01, "vibration while the hand holds")]


def wild_words(rows):
    wild = unique(r["scene"] for r in rows if not r["stable"])
    return f"not stable on {listed(map(html.escape, wild))}" if wild else "stable on all scenes"


@dataclass
class Quantity:
    """A figure of each window, as it is plotted."""

    key: str  # of a row
    label: str  # of the axis, with the unit
    words: Callable  # writes a value in the axis' unit
    floor: float  # range of the axis
    cap: float | None = None
    factor: float = 1  # from the row's unit to the axis'
    limits: tuple = ()  # (value, name) of lines in all panels
    floor_key: str | None = None  # a line that each scene has of its own: a key of the scene


class Windows:
    """Series by coupling and border (and cap on members, where several ran), panels by scene."""

    def __init__(self, data):
        self.data = data
        self.caps = {}
        for r in data["rows"]:
            self.caps.setdefault(r["scene"], set()).add(r["members"])
        self.rows = [r for r in data["rows"] if r["coupling"] != "direct"]  # the reference: no error by its definition
        self.scenes = {s["scene"]: s for s in data["scenes"]}
        self.series = unique(self.name(r) for r in self.rows)
        self.ratios = sorted(unique(r["ratio"] for r in self.rows))
        self.index_of = {name: i for i, name in enumerate(self.series)}
        compared = [n for n in self.ratios if n > 1] or self.ratios
        self.ratio = 8 if 8 in compared else compared[-1] if compared else None

    def name(self, row):
        return name_of(row, len(self.caps[row["scene"]]) > 1)

    def at_ratio(self, series=None):
        return [r for r in self.rows if r["ratio"] == self.ratio and series in (None, self.name(r))]

    def figure(self, page, quantity, caption):
        """One panel for each scene: the quantity by ratio."""
        key, factor, floor_key = quantity.key, quantity.factor, quantity.floor_key
        panels = []
        every = [times(one[key], factor) for r in self.rows for one in (r, *r.get("by_seed", []))]
        every += [times(about[floor_key], factor) for about in self.scenes.values()] if floor_key else []
        at_limits = [at for at, _ in quantity.limits]
        scale = figure.Scale(every, quantity.floor, quantity.cap, at_limits, far=math.inf)  # scenes are compared too
        for scene, about in self.scenes.items():
            panel = figure.Panel(scene, "ratio [ticks per global step]", quantity.label)
            for at, name in quantity.limits:
                panel.line(at, name)
            if floor_key and is_number(about[floor_key]):
                panel.line(scale.place(factor * about[floor_key])[0], "1 um apart", ls=figure.FLOOR_DASHES)
            series = {}
            for r in (r for r in self.rows if r["scene"] == scene):
                seeds = [factor * s[key] for s in r.get("by_seed", []) if is_number(s[key])]
                value = times(r[key], factor)
                series.setdefault(self.name(r), {})[r["ratio"]] = (
                    value, min(seeds, default=None), max(seeds, default=None), not r["stable"])
            figure.stepped(panel, self.ratios, series, scale, quantity.words, self.index_of)
            panels.append(panel.drawn(f"{page.title} {key}"))
        legend = figure.series_keys(self.series) + [(figure.key(theme.INK, "x"), "not stable with the hand in the loop")]
        legend += [(figure.key(ls=figure.LIMIT_DASHES), name) for _, name in quantity.limits]
        if floor_key:
            legend.append((figure.key(ls=figure.FLOOR_DASHES), "two direct runs that start 1 µm apart"))
        page.figure(panels, caption + f" Bars: from the least to the most of the hands (seeds: {self.data['seeds']}); where there is "
                    "none, it is within the mark, or there is one hand only. Within a ratio the series stand side by side, in "
                    "the legend's order.", legend)

    def figures(self, page):
        percent = lambda v: share(v / 100)
        page.head("Force")
        self.figure(page, Quantity("force_error_rms", "force error [%]", percent, 0.01, 1000, factor=100,
                                   limits=((100 * NOTICED, "7 %: a hand notices"),), floor_key="apart_1um_force_error"),
                    "Force error, RMS(F − F<sub>direct</sub>) / RMS(F<sub>direct</sub>), over all windows. Below the dotted line "
                    "nothing can be told from chance.")
        page.head("Energy")
        basis = ("Of the kinetic energy of all bodies against the direct coupling, while the hand moves, window by window, each "
                 "weighed by its energy; where the reference is at rest, of its kinetic energy and of what the coupling's "
                 "spring holds.")
        self.figure(page, Quantity("loss", "energy lost [%]", percent, 0.01, 1000, factor=100), "Energy lost. " + basis)
        self.figure(page, Quantity("gain", "energy gained [%]", percent, 0.01, 1000, factor=100), "Energy gained. " + basis)
        page.head("Vibration")
        self.figure(page, Quantity("hold_vibration_N", "vibration [N]", newton, 1e-5, 100,
                                   limits=((0.01, "0.01 N: our target"),)),
                    "Vibration while the hand holds still, ideal encoder: standard deviation of F − F<sub>direct</sub> between "
                    "20 and 500 Hz, median of the windows.")
        self.figure(page, Quantity("sync_step_N", "step of force [N]", newton, 1e-4, 100),
                    "Force step at a synchronisation: 95 % of the steps of F − F<sub>direct</sub> are smaller.")
        self.spectra(page)

    def spectra(self, page):
        line = self.data["spectrum_line_Hz"]
        if self.ratio is None or not is_number(line) or line <= 0:
            return
        curves = {}
        for r in self.at_ratio():
            power = r["spectrum_N2"]
            if len(power) > 2:
                curves.setdefault(r["scene"], {})[self.name(r)] = [
                    (k * line, math.sqrt(power[k]) if is_number(power[k]) and power[k] >= 0 else math.nan)
                    for k in range(1, len(power))]
        if not curves:
            return
        x = figure.Scale([at for scene in curves.values() for points in scene.values() for at, _ in points])
        y = figure.Scale([v for scene in curves.values() for points in scene.values() for _, v in points], floor=1e-8, cap=100, far=math.inf)
        panels = []
        for scene, by_name in curves.items():
            panel = figure.Panel(scene, "frequency [Hz]", "amplitude of a line [N]")
            x.apply(panel.axis, "x"), y.apply(panel.axis, "y")
            panel.line(1000 / self.ratio, "synchronisations", "v")
            same = figure.coincident(by_name)
            for name, points in by_name.items():
                look = theme.style(self.index_of[name])
                if name in same:
                    panel.note(f"{html.escape(name)} has the curve of {html.escape(same[name])}.")
                    continue
                drawn = [(at, *y.place(v)) for at, v in points]
                panel.off_scale(name, [f"{newton(v)} at {exact(at)} Hz" for at, v in points if y.place(v)[1] and is_number(v)][:3])
                panel.axis.plot([d[0] for d in drawn if d[1]], [d[1] for d in drawn if d[1]], color=look["color"],
                                ls=look["ls"], lw=1, gid=f"series {html.escape(name)}")
            panels.append(panel.drawn(f"{page.title} spectrum"))
        legend = [(figure.key(**{**theme.style(i), "marker": None}), name) for i, name in enumerate(self.series)]
        legend.append((figure.key(ls=figure.LIMIT_DASHES), f"synchronisations, {exact(1000 / self.ratio)} Hz"))
        page.figure(panels, f"Spectrum of F − F<sub>direct</sub> while the hand holds still, ratio {self.ratio}, lines of "
                    f"{exact(line)} Hz, mean of all hands' windows.", legend)

    def sentences(self):
        """One for each series at the ratio that is compared, the least error first."""
        def most(name):
            return worst(self.at_ratio(name), "force_error_rms")["force_error_rms"]
        there = [name for name in self.series if self.at_ratio(name)]
        there.sort(key=lambda n: (most(n) if is_number(most(n)) else math.inf))
        return there, [
            f"<b>{html.escape(name)}</b>: the force is off by {worst_words(self.at_ratio(name), 'force_error_rms', bound=True)}; "
            f"energy lost: {worst_words(self.at_ratio(name), 'loss', bound=True)}; gained: "
            f"{worst_words(self.at_ratio(name), 'gain', bound=True)}; {wild_words(self.at_ratio(name))}." for name in there]

    def targets(self, page):
        ours = [r for r in self.rows if r["coupling"] == "sub-world" and r["border"] == OURS]
        lines = []
        for ratio, key, limit, words in TARGETS:
            mine = [r for r in ours if r["ratio"] == ratio]
            if not mine:
                continue
            write = newton if key.endswith("_N") else share
            value = worst(mine, key)[key]
            reached = is_number(value) and value <= limit
            lines.append([f"{words} at ratio {ratio}", f"at most {exact(100 * limit)} %" if write is share else f"at most {exact(limit)} N", worst_words(mine, key, write),
                          Cell("reached" if reached else "MISSED", "good" if reached else "bad")])
        if lines:
            page.head(f"Our targets, for the sub-world with the border {OURS}")
            page.table([Column("target", "what is limited, in the worst scene", "t"), Column("limit", "ours", "t"),
                        Column("measured", "the worst scene's, over all hands", "t"), Column("verdict", "of the two", "t")], lines)

    def side_by_side(self, page):
        if self.ratio is None:
            return
        page.head(f"Force error at ratio {self.ratio}, and where it is stable")
        lines = []
        for scene in self.scenes:
            line = [scene]
            for name in self.series:
                rows = [r for r in self.at_ratio(name) if r["scene"] == scene]
                line.append("–" if not rows else Cell(share(rows[0]["force_error_rms"]) + (
                    "" if rows[0]["stable"] else ", not stable"), "" if rows[0]["stable"] else "bad"))
            lines.append(line)
        page.table([Column("scene", "the world, described below", "t"),
                    *[Column(name, "its force error over all windows; with the hand in the loop stable, or not") for name in
                      self.series]], lines)
        page.head("Stability by ratio")
        lines = []
        for name in self.series:
            line = [name]
            for scene in self.scenes:
                mine = [r for r in self.rows if r["scene"] == scene and self.name(r) == name]
                wild = [r["ratio"] for r in mine if not r["stable"]]
                line.append("–" if not mine else Cell("stable") if not wild else
                            Cell(f"NOT at {', '.join(map(str, sorted(wild)))}", "bad"))
            lines.append(line)
        page.table([Column("coupling", "and border", "t"),
                    *[Column(scene, "the ratios at which it is not stable with the hand in the loop, the device's encoder and "
                             "delay") for scene in self.scenes]], lines)

    def scene_table(self, page):
        page.head("The scenes")
        page.table([Column("scene", "its name", "t"), Column("bodies", "all that move"),
                    Column("contact graph", "the largest that hangs together with the hand's proxy, bodies"),
                    Column("members", "cap of the sub-world, bodies"), Column("contact points", "most at once"),
                    Column("in contact", "share of the windows' ticks in which the hand touches"),
                    Column("force", "RMS of the direct coupling's"),
                    Column("force error, 1 µm", "of a second direct run that starts 1 µm aside"),
                    Column("energy lost, 1 µm", "by that run"), Column("energy gained, 1 µm", "by that run")],
                   [[s["scene"], count(s["bodies"]), count(s["component"]), count(s["members_cap"]), count(s["contact_points"]),
                     share(s["contact_share"]), newton(s["force_rms_N"]), share(s["apart_1um_force_error"]),
                     share(s["apart_1um_loss"]), share(s["apart_1um_gain"])] for s in self.scenes.values()])

    def row_tables(self, page):
        who = [Column("scene", "", "t"), Column("coupling", "", "t"), Column("border", "how members feel the outside", "t"),
               Column("ratio", "haptic ticks per global step")]
        def names(r):
            return [r["scene"], r["coupling"], r["border"], r["ratio"]]
        who[0].meaning, who[1].meaning = "the world", "the scheme"
        page.head("All figures of the windows: force")
        def seeds(r, key, write):
            values = [s[key] for s in r.get("by_seed", []) if is_number(s[key])]
            return f"{write(min(values))} … {write(max(values))}" if values else "–"
        page.table([*who, Column("force error", "over all windows"), Column("by hand", "least and most of the seeds"),
                    Column("hold", "in the windows where the hand holds"), Column("moving", "where it moves"),
                    Column("worst window", "of all"), Column("K", "the coupling's stiffness in world units, N/m; !: lowered to "
                                                             "what the coupling bears"),
                    Column("peak", "largest force with the hand in the loop"), Column("stable", "with the hand in the loop")],
                   [[*names(r), share(r["force_error_rms"]), seeds(r, "force_error_rms", share), share(r["force_error_hold"]),
                     share(r["force_error_moving"]), share(r["force_error_worst_window"]),
                     number(r["stiffness_N_per_m"]) + ("!" if r["stiffness_lowered"] else ""), newton(r["loop_peak_N"]),
                     "yes" if r["stable"] else Cell("NO", "bad")] for r in self.data["rows"]])
        page.head("All figures of the windows: energy and vibration")
        page.table([*who, Column("basis", "what L1 and L2 are shares of", "t"), Column("loss L1", "of the energy, by window"),
                    Column("gain L1", "the same"), Column("loss L2", "at the worst instant"), Column("gain L2", "the same"),
                    Column("loss L3", "of the sum of squared speeds"), Column("gain L3", "the same; over 1000×: the reference "
                                                                           "is at rest, and no share can be told"),
                    Column("sync step", "95 % of the force's steps at synchronisations are smaller"),
                    Column("vibration", "20 to 500 Hz while the hand holds, ideal encoder"),
                    Column("with encoder", "the same with the device's encoder")],
                   [[*names(r), r["energy_basis"], share(r["loss"]), share(r["gain"]), share(r["loss_worst_instant"]),
                     share(r["gain_worst_instant"]), share(r["loss_speed_squared"]), share(r["gain_speed_squared"]),
                     newton(r["sync_step_N"]), newton(r["hold_vibration_N"]), newton(r["hold_vibration_encoder_N"])]
                    for r in self.data["rows"]])


def answer(windows, names, what):
    scenes, hands = len(windows.scenes), windows.data["seeds"]
    if not names:
        return "Nothing can be compared: no coupling but the direct one was run."
    rows = windows.at_ratio
    over = f"over {scenes} scene{'s' if scenes != 1 else ''} and {hands} hand{'s' if hands != 1 else ''}"
    if what == "energy-loss":
        own = next((n for n in names if OURS in n), names[0])
        return (f"At ratio {windows.ratio} the {html.escape(own)} puts the force off by "
                f"{worst_words(rows(own), 'force_error_rms', bound=True)}, {over}; of the energy it loses "
                f"{worst_words(rows(own), 'loss', bound=True)} and gains {worst_words(rows(own), 'gain', bound=True)}; it is "
                f"{wild_words(rows(own))}.")
    stable = [n for n in names if all(r["stable"] for r in rows(n))]
    next_best = (f", the next, {html.escape(names[1])}, by {worst_words(rows(names[1]), 'force_error_rms', bound=True)}" if len(names) > 1
                 else "")
    return (f"At ratio {windows.ratio} the force of {html.escape(names[0])} is off by "
            f"{worst_words(rows(names[0]), 'force_error_rms', bound=True)}{next_best}, {over}; stable on all scenes: "
            f"{listed(map(html.escape, stable)) if stable else 'none'}.")


def coupling_page(data, page, what):
    windows = Windows(data)
    names, sentences = windows.sentences()
    page.answer(answer(windows, names, what))
    page.findings(sentences + whole_sentences(data["whole"]))
    page.text(f"Hands: {data['seeds']}, each with {data['windows_per_seed']} windows of {data['window_cycles']} cycles, at least "
              f"{exact(1000 * data['window_least_s'])} ms. Every window starts from the state of a run with direct coupling "
              "(all bodies at 1 kHz), contact impulses included, and has that run's hand motion: what differs is the coupling "
              "alone. Ratio: haptic ticks for each step of the global world. Virtual time: the same options give the same "
              "figures on any machine.")
    if not names:
        windows.scene_table(page)
        return
    windows.targets(page)
    windows.side_by_side(page)
    page.text("Not stable, with the hand in the loop: force or shaking beyond what the direct coupling does, a body that does not "
              "stand at the end, or energy beyond the direct run's (the command's --help has the limits).")
    windows.figures(page)
    windows.scene_table(page)
    if data["whole"]:
        whole_runs(data["whole"], page)
    windows.row_tables(page)
