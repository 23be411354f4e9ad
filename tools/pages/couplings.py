"""The page of `energy-loss` and `couplings`: windows, whole runs, and what they say."""
import html

import matplotlib
import matplotlib.pyplot as plt

from pages import findings
from pages.parts import COLOURS, MARKS, panels, share, unique, worst


def nested(i):
    """The look of series i: the later, the smaller, so that those that coincide are all seen."""
    return {"color": COLOURS[i % len(COLOURS)], "marker": MARKS[i % len(MARKS)], "ms": 8 - 0.8 * (i % 7),
            "lw": 3 - 0.35 * (i % 7)}


class Couplings:
    """What `energy-loss` and `couplings` have in common: series by coupling and border, panels by scene."""

    def __init__(self, data):
        self.data, self.rows = data, data["rows"]
        self.scenes = {s["scene"]: s for s in data["scenes"]}
        self.series = unique(self.name(r) for r in self.rows)

    @staticmethod
    def name(row):
        return row["coupling"] if row["border"] == "-" else f"{row['coupling']}, {row['border']}"

    def of(self, scene, series):
        return sorted((r for r in self.rows if r["scene"] == scene and self.name(r) == series),
                      key=lambda r: r["ratio"])

    def by_ratio(self, draw, label, log=True, least=None):
        fig, axes = panels(list(self.scenes))
        ratios = sorted(unique(r["ratio"] for r in self.rows))
        for axis, scene in zip(axes, self.scenes):
            for i, series in enumerate(self.series):
                rows = self.of(scene, series)
                if rows:
                    draw(axis, rows, {**nested(i), "label": series})
            axis.set_title(scene, fontsize=10)
            axis.set_xscale("log", base=2)
            axis.set_xticks(ratios, [str(r) for r in ratios])
            axis.minorticks_off()
            if log:
                axis.set_yscale("log")
        # The same in all panels: scenes are compared too. What is below the least lies on the lower edge.
        if log:
            top = max(axis.get_ylim()[1] for axis in axes)
            for axis in axes:
                axis.set_ylim(0.8 * least, max(1.5 * top, 10 * least))
        for axis in axes[::4]:
            axis.set_ylabel(label)
        axes[-1].set_xlabel("ratio")
        handles, labels = axes[0].get_legend_handles_labels()
        fig.legend(handles, labels, loc="upper center", ncol=4, bbox_to_anchor=(0.5, 0))
        return fig, axes

    def one_curve(self, key, scale=1.0, floor=1e-12):
        def draw(axis, rows, style):
            at = [r["ratio"] for r in rows]
            axis.plot(at, [max(floor, scale * r[key]) for r in rows], **style)
            wild = [r for r in rows if not r["stable"]]
            axis.plot([r["ratio"] for r in wild], [max(floor, scale * r[key]) for r in wild], ls="none", marker="x",
                      ms=9, mew=1.5, color="#222")
        return draw

    def force_figure(self, page):
        fig, axes = self.by_ratio(self.one_curve("force_error_rms", 100, 1e-2), "force error [%]", least=1e-2)
        for axis, scene in zip(axes, self.scenes.values()):
            axis.axhline(5, color="#888", lw=0.8, ls="--")
            axis.axhline(max(1e-2, 100 * scene["apart_1um_force_error"]), color="#888", lw=0.8, ls=":")
        page.figure(fig, "Force error, RMS(F &minus; F<sub>direct</sub>) / RMS(F<sub>direct</sub>), over all windows. "
                    "Dashed: 5 %, a hand notices about 7 %. Dotted: two direct runs that start 1 &micro;m apart; less "
                    "cannot be told from chance. Crosses: not stable with the hand in the loop.")

    def energy_figure(self, page):
        def draw(axis, rows, style):
            at = [r["ratio"] for r in rows]
            axis.plot(at, [-100 * r["loss"] for r in rows], **style)
            axis.plot(at, [100 * r["gain"] for r in rows], **{**style, "label": None, "mfc": "white", "ls": "--"})
        fig, axes = self.by_ratio(draw, "energy [%]", log=False)
        for axis in axes:
            axis.set_yscale("symlog", linthresh=0.1)
            axis.axhline(0, color="#222", lw=0.8)
            axis.set_ylim(-100, 1e6)
            axis.set_yticks([-100, -1, 0, 1, 100, 1e4, 1e6], ["-100", "-1", "0", "1", "100", "1e4", "1e6"])
        page.figure(fig, "Kinetic energy of all bodies against the direct coupling: lost (filled, below zero) and gained "
                    "(open, above), while the hand moves, window by window, each weighed by its energy. Where the reference is at rest: shares of "
                    "its kinetic energy and of what the coupling's spring holds. Linear within 0.1 %, logarithmic beyond.")

    def vibration_figure(self, page):
        fig, axes = self.by_ratio(self.one_curve("hold_vibration_N", 1, 1e-5), "vibration [N]", least=1e-5)
        for axis in axes:
            axis.axhline(0.01, color="#888", lw=0.8, ls="--")
        page.figure(fig, "Vibration while the hand holds still, ideal encoder: standard deviation of "
                    "F &minus; F<sub>direct</sub> between 20 and 500 Hz, median of the windows. Dashed: 0.01 N.")
        fig, axes = self.by_ratio(self.one_curve("sync_step_N", 1, 1e-4), "step [N]", least=1e-4)
        for axis in axes:
            axis.axhline(0.05, color="#888", lw=0.8, ls="--")
        page.figure(fig, "Force step at a synchronisation: 95 % of the steps of F &minus; F<sub>direct</sub> are smaller. "
                    "Dashed: 0.05 N.")

    def spectrum_figure(self, page):
        ratios = sorted(unique(r["ratio"] for r in self.rows if r["ratio"] > 1))
        if not ratios:
            return
        ratio = 8 if 8 in ratios else ratios[-1]
        line = self.data["spectrum_line_Hz"]
        fig, axes = panels(list(self.scenes))
        for axis, scene in zip(axes, self.scenes):
            for i, series in enumerate(self.series):
                for row in self.of(scene, series):
                    power = row["spectrum_N2"]
                    if row["ratio"] != ratio or len(power) < 3:
                        continue
                    at = [k * line for k in range(1, len(power))]
                    axis.plot(at, [max(1e-9, p ** 0.5) for p in power[1:]], color=COLOURS[i % len(COLOURS)], lw=1, label=series)
            axis.axvline(1000 / ratio, color="#888", lw=0.8, ls="--")
            axis.set_xscale("log"), axis.set_yscale("log")
            axis.set_title(scene, fontsize=10)
        for axis in axes[::4]:
            axis.set_ylabel("line [N]")
        axes[-1].set_xlabel("frequency [Hz]")
        handles, labels = axes[0].get_legend_handles_labels()
        fig.legend(handles, labels, loc="upper center", ncol=4, bbox_to_anchor=(0.5, 0))
        page.figure(fig, f"Spectrum of F &minus; F<sub>direct</sub> while the hand holds still, ratio {ratio}, lines of "
                    f"{line:g} Hz. Dashed: the rate of synchronisations, {1000 / ratio:g} Hz.")

    def stability_figure(self, page):
        names = list(self.scenes)
        ratios = sorted(unique(r["ratio"] for r in self.rows))
        fig, axes = plt.subplots(1, len(self.series), figsize=(2.6 * len(self.series), 2.6), squeeze=False,
                                 constrained_layout=True)
        for axis, series in zip(axes[0], self.series):
            cells = [[float("nan")] * len(ratios) for _ in names]
            for y, scene in enumerate(names):
                for row in self.of(scene, series):
                    cells[y][ratios.index(row["ratio"])] = 0.0 if row["stable"] else 1.0
                    axis.text(ratios.index(row["ratio"]), y, "" if row["stable"] else "x", ha="center", va="center")
            axis.imshow(cells, cmap=matplotlib.colors.ListedColormap(["#cfe8dc", "#f3b69a"]), vmin=0, vmax=1,
                        aspect="auto")
            axis.set_xticks(range(len(ratios)), [str(r) for r in ratios])
            axis.set_yticks(range(len(names)), names if axis is axes[0][0] else [""] * len(names))
            axis.set_title(series, fontsize=9), axis.set_xlabel("ratio"), axis.grid(False)
        page.figure(fig, "Stability with the hand in the loop, the device's encoder and delay. Green: stable; white: not run; x: force or "
                    "shaking beyond what the direct coupling does, a body that does not stand at the end, or energy beyond "
                    "the direct run's (the command's --help has the limits).")

    def verdicts(self, page, targets):
        page.head("What was aimed at, and what came out")
        lines = []
        for words, ok, value in targets:
            lines.append([words, value, "reached" if ok else "MISSED"])
        page.table(["target", "measured", ""], lines)

    def best_table(self, page):
        """Which series has the least force error, by scene, at 8 or the largest ratio."""
        ratios = sorted(unique(r["ratio"] for r in self.rows if r["ratio"] > 1))
        if not ratios:
            return
        ratio = 8 if 8 in ratios else ratios[-1]
        page.head(f"Side by side at ratio {ratio}: force error, and whether it is stable")
        lines = []
        for scene in self.scenes:
            line = [scene]
            for series in self.series:
                row = next((r for r in self.of(scene, series) if r["ratio"] == ratio), None)
                line.append("-" if row is None else share(row["force_error_rms"]) + ("" if row["stable"] else ", not stable"))
            lines.append(line)
        page.table(["scene", *self.series], lines)

    def scene_table(self, page):
        page.head("The scenes")
        page.table(["scene", "", "", "bodies", "contact graph", "members", "contact points", "in contact", "force RMS",
                    "force error, 1 um apart", "loss / gain, 1 um apart"],
                   [[s["scene"], "", "", s["bodies"], s["component"], s["members_cap"], s["contact_points"],
                     share(s["contact_share"]), f"{s['force_rms_N']:.2f} N", share(s["apart_1um_force_error"]),
                     f"{share(s['apart_1um_loss'])} / {share(s['apart_1um_gain'])}"] for s in self.scenes.values()])

    def row_table(self, page):
        page.head("All figures of the windows")
        page.text("L1: of the kinetic energy, by window; L2: the worst instant; L3: of the sum of squared speeds. <i>energy "
                  "of</i>: what L1 and L2 are shares of.")
        page.table(["scene", "coupling", "border", "ratio", "energy of", "loss L1", "gain L1", "loss L2", "gain L2", "loss L3",
                    "gain L3", "force error", "hold", "moving", "worst window", "sync step N", "vibration N", "encoder N",
                    "peak N", "stable"],
                   [[r["scene"], r["coupling"], r["border"], r["ratio"], r["energy_basis"], share(r["loss"]), share(r["gain"]),
                     share(r["loss_worst_instant"]), share(r["gain_worst_instant"]), share(r["loss_speed_squared"]),
                     share(r["gain_speed_squared"]), share(r["force_error_rms"]), share(r["force_error_hold"]),
                     share(r["force_error_moving"]), share(r["force_error_worst_window"]), f"{r['sync_step_N']:.4f}",
                     f"{r['hold_vibration_N']:.5f}", f"{r['hold_vibration_encoder_N']:.5f}", f"{r['loop_peak_N']:.1f}",
                     "yes" if r["stable"] else "no"] for r in self.rows])


def whole_runs(rows, page):
    page.head(f"Whole runs of {rows[0]['seconds']:g} s")
    page.text("From rest, with the scene's own hand: <i>closed</i>, its arm in the loop of the run itself; <i>direct</i>, "
              "the arm's motion of the direct run. <i>By quarter</i>: each over the "
              "force of the whole run. <i>1 um apart</i>: a direct run whose proxy starts 1 &micro;m aside.")
    scenes = unique(r["scene"] for r in rows)
    tested = [r for r in rows if r["started_apart_m"] == 0 and r["hand"] == "closed"]
    series = unique(findings.name_of(r) for r in tested)
    ratios = sorted(unique(r["ratio"] for r in tested))
    fig, axes = panels(scenes)
    for axis, scene in zip(axes, scenes):
        for i, name in enumerate(series):
            mine = sorted((r for r in tested if r["scene"] == scene and findings.name_of(r) == name),
                          key=lambda r: (r["ratio"], r["members"]))
            axis.plot([r["ratio"] for r in mine], [max(1e-2, 100 * r["force_error"]) for r in mine], label=name,
                      **nested(i))
            down = [r for r in mine if not r["stands"]]
            axis.plot([r["ratio"] for r in down], [max(1e-2, 100 * r["force_error"]) for r in down], ls="none",
                      marker="x", ms=9, mew=1.5, color="#222")
        for r in rows:
            if r["scene"] == scene and r["started_apart_m"] > 0:
                axis.axhline(max(1e-2, 100 * r["force_error"]), color="#888", lw=0.8, ls=":")
        axis.set_title(scene, fontsize=10), axis.set_xscale("log", base=2), axis.set_yscale("log")
        axis.set_xticks(ratios, [str(n) for n in ratios]), axis.minorticks_off()
    top = max(axis.get_ylim()[1] for axis in axes)
    for axis in axes:
        axis.set_ylim(0.8e-2, max(1.5 * top, 0.1))
    for axis in axes[::4]:
        axis.set_ylabel("force error [%]")
    axes[-1].set_xlabel("ratio")
    handles, labels = axes[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="upper center", ncol=4, bbox_to_anchor=(0.5, 0))
    page.figure(fig, "Force error over the whole run, RMS(F &minus; F<sub>direct</sub>) / RMS(F<sub>direct</sub>), closed "
                "hand. Crosses: a body does not stand at the end. Dotted: two direct runs, 1 &micro;m apart.")
    page.table(["scene", "coupling", "border", "ratio", "members", "hand", "force error", "by quarter", "off at end mm",
                "off at most mm", "off, of size", "drift mm", "kinetic / work", "energy gained, of that at play",
                "border on members J", "stands"],
               [[r["scene"], "1 um apart" if r["started_apart_m"] > 0 else r["coupling"], r["border"], r["ratio"], r["members"],
                 r["hand"], share(r["force_error"]), " / ".join(f"{100 * q:.3g}" for q in r["force_error_by_quarter"]) + " %",
                 f"{1e3 * r['pose_off_m']:.3f}", f"{1e3 * r['pose_off_most_m']:.3f}", share(r["pose_off_share_of_size"]),
                 f"{1e3 * r['drift_m']:.4f}", f"{r['kinetic_over_work']:.3f}",
                 share((r["energy_gain_J"] - r["direct_energy_gain_J"]) / r["energy_at_play_J"]), f"{r['border_work_J']:+.4f}",
                 "yes" if r["stands"] else f"NO, {r['fallen']} fell"] for r in rows])


def coupling_page(data, page, what):
    c = Couplings(data)
    page.findings(findings.of_windows(c.rows) + findings.of_whole_runs(data["whole"]))
    page.text(f"Hands: {data['seeds']}, each with {data['windows_per_seed']} windows of {data['window_cycles']} cycles, at least "
              f"{data['window_least_s'] * 1000:.0f} ms. Every window starts from the state of a run with direct coupling (all bodies at 1 kHz), contact impulses "
              "included, and has that run's hand motion: what differs is the coupling alone. <i>ratio</i>: haptic ticks "
              "for each step of the global world.")
    targets = []
    for border in unique(r["border"] for r in c.rows if r["coupling"] == "sub-world"):
        at = lambda n: [r for r in c.rows if r["coupling"] == "sub-world" and r["border"] == border and r["ratio"] == n]
        for ratio, key, limit, words in [(8, "loss", 0.01, "worst loss of energy"), (8, "gain", 0.001, "worst gain"),
                                         (16, "loss", 0.02, "worst loss of energy"),
                                         (8, "force_error_rms", 0.05, "worst force error")]:
            if at(ratio):
                targets.append((f"{border}, ratio {ratio}: {words} <= {100 * limit:g} %", *worst(at(ratio), key, limit)))
        if at(8):
            targets.append((f"{border}, ratio 8: vibration at hold <= 0.01 N",
                            *worst(at(8), "hold_vibration_N", 0.01, "N")))
    c.verdicts(page, targets)
    c.best_table(page)
    c.scene_table(page)
    page.head("Force")
    c.force_figure(page)
    page.head("Energy lost and gained, of the kinetic energy; where the scene is at rest, of that and the coupling's spring")
    c.energy_figure(page)
    page.head("Vibration")
    c.vibration_figure(page)
    c.spectrum_figure(page)
    page.head("Stability")
    c.stability_figure(page)
    if data["whole"]:
        whole_runs(data["whole"], page)
    c.row_table(page)
