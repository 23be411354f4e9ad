"""The page of `tactus experiment stability-map`."""
import html

from pages import figure, theme
from pages.numbers import exact, is_number, number, times, unit
from pages.page import Cell, Column
from pages.rows import unique

# factor: (key, scale to what is written, how it is written)
FACTORS = {"rate": ("rate_Hz", 1, "{} Hz"), "delay": ("delay_ticks", 1, "delay of {} ticks"),
           "jitter": ("jitter_ticks", 1, "jitter of up to {} ticks"), "quantum": ("quantum_m", 1e6, "encoder step of {} µm")}
MEASURED, FORMULA, ALLOWED, LINE = "measured_N_per_m", "formula_N_per_m", "allowed_N_per_m", "line_N_per_m"


def value_words(row):
    key, scale, words = FACTORS[row["factor"]]
    return words.format(number(scale * row[key]) if row["factor"] == "quantum" else exact(row[key]))


def answer(data):
    use, rows = data["suggested"], data["rows"]
    below = (f"none of the {len(rows)} measured boundaries lies below what is allowed" if not data["unsafe"] else
             f"{data['unsafe']} of the {len(rows)} measured boundaries LIE BELOW what is allowed")
    if not is_number(use["stiffness_N_per_m"]) or use["stiffness_N_per_m"] <= 0:
        return f"No gains can be given for {html.escape(data['device'])} at {exact(data['rate_Hz'])} Hz on this PC; {below}."
    return (f"On this PC {html.escape(data['device'])} at {exact(data['rate_Hz'])} Hz may have a stiffness of "
            f"{unit(use['stiffness_N_per_m'], 'N/m')} with {unit(use['damping_Ns_per_m'], 'N s/m')} of damping; {below}.")


def map_figure(data, page):
    every = [r[k] for r in data["rows"] for k in (MEASURED, FORMULA, ALLOWED) if is_number(r[k]) and r[k] > 0]
    y = figure.Scale(every)
    x = figure.Scale([r["damping_Ns_per_m"] for r in data["rows"]])
    values = unique(value_words(r) for r in data["rows"])
    look_of = {words: theme.style(i) for i, words in enumerate(values)}
    panels = []
    for factor in unique(r["factor"] for r in data["rows"]):
        panel = figure.Panel(f"by {factor}", "damping [N s/m]", "stiffness [N/m]")
        x.apply(panel.axis, "x"), y.apply(panel.axis, "y")
        for words in unique(value_words(r) for r in data["rows"] if r["factor"] == factor):
            mine = sorted((r for r in data["rows"] if r["factor"] == factor and value_words(r) == words),
                          key=lambda r: r["damping_Ns_per_m"])
            look = look_of[words]
            lost = [number(r["damping_Ns_per_m"]) for r in mine if not is_number(r[MEASURED])]
            if lost:
                panel.note(f"{words}: no finite number at {', '.join(lost)} N s/m.")
            none = [number(r["damping_Ns_per_m"]) for r in mine if is_number(r[MEASURED]) and r[MEASURED] <= 0]
            if none:
                panel.note(f"{words}: no stiffness is stable at {', '.join(none)} N s/m.")
            off = [f"{unit(r[MEASURED], 'N/m')} at {number(r['damping_Ns_per_m'])} N s/m" for r in mine if y.place(r[MEASURED])[1]]
            panel.off_scale(words, off)
            for key, ls, lw in ((FORMULA, "-", 1.2), (ALLOWED, (0, (4, 2)), 1), (LINE, (0, (1, 1.5)), 1)):
                drawn = [r for r in mine if is_number(r[key]) and 0 < r[key]]
                panel.axis.plot([r["damping_Ns_per_m"] for r in drawn], [r[key] for r in drawn], color=look["color"], ls=ls, lw=lw,
                                gid=f"series {words}")
            seen = [r for r in mine if is_number(r[MEASURED]) and r[MEASURED] > 0]
            beyond = [r for r in seen if y.place(r[MEASURED])[1]]
            panel.beyond([r["damping_Ns_per_m"] for r in beyond], [y.place(r[MEASURED])[0] for r in beyond], look["color"])
            seen = [r for r in seen if r not in beyond]
            panel.axis.plot([r["damping_Ns_per_m"] for r in seen], [y.place(r[MEASURED])[0] for r in seen], ls="none",
                            marker=look["marker"], ms=5, mfc=look["color"], mec="none", gid=f"series {words}")
        panels.append(panel.drawn(f"{page.title} map"))
    legend = [(figure.key(look_of[words]["color"], look_of[words]["marker"]), words) for words in values]
    legend += [(figure.key(theme.MUTE, "o"), "mark: measured"), (figure.key(theme.MUTE, ls="-"), "formula"),
               (figure.key(theme.MUTE, ls=(0, (4, 2))), "allowed by tactus run"),
               (figure.key(theme.MUTE, ls=(0, (1, 1.5))), "(b + B) / (T/2 + t_d)")]
    page.figure(panels, "Where a tap begins to ring on. Stable below. Measured by halving, one hand: no spread. Formula: 1 + L(z) = 0 "
                "on the unit circle for a mass under held force; the coupling's own lead, half a tick and half a sub-step, is not in "
                f"it, so that it is on the safe side. Allowed: {exact(data['allowed_share'])} of it. Dotted: right for little "
                "damping only; it leaves the panel where it goes beyond what is measured.", legend)


def stability_page(data, page, what):
    rows, wake, use = data["rows"], data["wake"], data["suggested"]
    page.answer(answer(data))
    page.text(f"The simulated device {html.escape(data['device'])} is pressed against a wall with 5 N through the coupling and "
              "tapped; no passivity controller, no dry friction, no damping by the hand. Measured: the stiffness at which the tap "
              "begins to ring on, found by halves for each damping of the coupling.")
    page.head("What to use on this PC")
    degraded = " (without real-time privileges)" if wake["degraded"] else ""
    page.table([Column("key", "as it is written under [coupling] in a scene or a configuration", "t"),
                Column("value", f"for {exact(data['rate_Hz'])} Hz, and ticks late by up to what one in a thousand exceeds")],
               [[key, number(use[key])] for key in ("stiffness_N_per_m", "damping_Ns_per_m", "stiffness_Nm_per_rad",
                                                    "damping_Nms_per_rad")])
    page.table([Column("wake-ups of the loop", f"measured: {html.escape(wake['source'])}{degraded}", "t"),
                Column("late by", "after the time it asked for, µs")],
               [["half are later than", number(wake["p50_us"])], ["one in a thousand is later than", number(wake["p99_9_us"])],
                ["the latest", number(wake["max_us"])]])
    page.head("What is stable")
    if rows:
        map_figure(data, page)
        page.text(f"The least measured / formula on this page is {number(data['least_measured_over_formula'])}; "
                  f"{data['unsafe']} of {len(rows)} boundaries are below what is allowed.")
    page.head("All figures")
    page.table([Column("factor", "what is varied", "t"), Column("rate", "of the loop, Hz"), Column("delay", "ticks"),
                Column("jitter", "ticks late, at most"), Column("quantum", "encoder step, µm"),
                Column("damping", "of the coupling, N s/m"), Column("measured", "stiffness where it rings on, N/m; 0: none is stable"),
                Column("formula", "N/m; 0: none is stable"), Column("allowed", "by tactus run, N/m"),
                Column("measured / formula", "below the allowed share: not safe")],
               [[r["factor"], exact(r["rate_Hz"]), exact(r["delay_ticks"]), exact(r["jitter_ticks"]),
                 number(times(r["quantum_m"], 1e6)), number(r["damping_Ns_per_m"]),
                 Cell(number(r[MEASURED]), "bad" if is_number(r[MEASURED]) and r[MEASURED] < r[ALLOWED] else ""),
                 number(r[FORMULA]), number(r[ALLOWED]),
                 number(r[MEASURED] / r[FORMULA]) if is_number(r[MEASURED]) and is_number(r[FORMULA]) and r[FORMULA] > 0 else "–"]
                for r in rows])
