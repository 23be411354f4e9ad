"""The page of `tactus experiment capacity`."""
import html

from pages import figure, theme
from pages.numbers import count, exact, is_number, number, share
from pages.page import Cell, Column
from pages.rows import unique

TARGET = {"coupling": "sub-world", "rate_Hz": 1000, "ratio": 10, "bodies": 5000}  # ours: sim/scenes/pile5000.toml


def bracket(row):
    if not row["bodies"]:
        return f"not even the smallest heap, {count(row['too_many'])}" if row["too_many"] else "none"
    return f"{count(row['bodies'])} cubes"


def answer(data):
    own = [r for r in data["rows"] if r["coupling"] == "sub-world"]
    if not own:
        return "The sub-world was not run: the page shows the other couplings alone."
    row = next((r for r in own if r["rate_Hz"] == 1000 and r["ratio"] == 10), max(own, key=lambda r: r["bodies"] or 0))
    direct = next((r for r in data["rows"] if r["coupling"] == "direct" and r["rate_Hz"] == row["rate_Hz"]), None)
    beside = ("; the direct coupling was not run beside it" if direct is None else
              f", {number(row['times_direct'])} times the {count(direct['bodies'])} of the direct coupling"
              if is_number(row["times_direct"]) else "; the direct coupling does not sustain the smallest heap")
    end = (f"; at {count(row['too_many'])} its {html.escape(row['breaks_by'])} is too slow" if row["too_many"] else
           "; no larger heap was tried, so this is no limit" if row["bodies"] else "")
    return (f"On this PC the sub-world sustains {bracket(row)} at {exact(row['rate_Hz'])} Hz and ratio {row['ratio']}"
            f"{beside}{end}.")


def sustained_figure(data, page):
    rows = [r for r in data["rows"] if r["bodies"]]
    if not rows:
        page.text("No coupling sustains the smallest heap: there is nothing to draw.")
        return
    couplings = unique(r["coupling"] for r in data["rows"])
    index_of = {name: i for i, name in enumerate(couplings)}
    scale = figure.Scale([r["bodies"] for r in rows] + [r["too_many"] for r in rows if r["too_many"]])
    panels = []
    for rate in unique(r["rate_Hz"] for r in data["rows"]):
        ratios = sorted(unique(r["ratio"] for r in data["rows"] if r["rate_Hz"] == rate and r["coupling"] != "direct")) or [1]
        panel = figure.Panel(f"{exact(rate)} Hz", "ratio [ticks per global step]", "cubes sustained [1]")
        series = {}
        for r in (r for r in rows if r["rate_Hz"] == rate):
            for ratio in ratios if r["coupling"] == "direct" else [r["ratio"]]:  # it has no ratio: the same at each
                series.setdefault(r["coupling"], {})[ratio] = (r["bodies"], r["bodies"], r["too_many"] or r["bodies"], False)
        for r in (r for r in data["rows"] if r["rate_Hz"] == rate and not r["bodies"]):
            panel.note(f"{html.escape(r['coupling'])}, ratio {r['ratio']}: not even the smallest heap.")
        figure.stepped(panel, ratios, series, scale, count, index_of)
        panels.append(panel.drawn(f"{page.title} sustained"))
    page.figure(panels, "Cubes that each coupling sustains. Bars: up to the smallest heap that is too large, where one was found. "
                "The direct coupling has no ratio: it is drawn at each. Within a ratio the couplings stand side by side.",
                figure.series_keys(couplings))


def load_figure(data, page):
    couplings = unique(p["coupling"] for p in data["points"])
    panels = []
    for title, time, period in (("haptic tick", "tick_us_p99", lambda p: 1e6 / p["rate_Hz"]),
                                ("global step", "step_us_p90", lambda p: 1e6 * p["ratio"] / p["rate_Hz"])):
        loads = [(p, p[time] / period(p)) for p in data["points"] if is_number(p[time]) and p[time] > 0]
        if not loads:
            continue
        x, y = figure.Scale([p["bodies"] for p, _ in loads]), figure.Scale([load for _, load in loads], also=[1.0])
        panel = figure.Panel(title, "cubes [1]", "time / time that there is [1]")
        x.apply(panel.axis, "x"), y.apply(panel.axis, "y")
        panel.line(1, "too slow")
        same = figure.coincident({c: [(p["bodies"], load) for p, load in loads if p["coupling"] == c] for c in couplings})
        for i, coupling in enumerate(couplings):
            if coupling in same:
                panel.note(f"{html.escape(coupling)} has the points of {html.escape(same[coupling])}.")
                continue
            mine = [(x.place(p["bodies"])[0], *y.place(load), load, p) for p, load in loads if p["coupling"] == coupling]
            panel.off_scale(coupling, [f"{number(load)} at {count(p['bodies'])}" for _, _, off, load, p in mine if off])
            look = theme.style(i)
            panel.beyond([m[0] for m in mine if m[2]], [m[1] for m in mine if m[2]], look["color"])
            mine = [m for m in mine if not m[2]]
            panel.axis.plot([m[0] for m in mine], [m[1] for m in mine], ls="none", marker=look["marker"], ms=6 - 0.5 * i,
                            mfc="none" if i % 2 else look["color"], mec=look["color"], mew=1,
                            gid=f"series {html.escape(coupling)}")
        panels.append(panel.drawn(f"{page.title} load"))
    if panels:
        legend = [(figure.key(theme.style(i)["color"], theme.style(i)["marker"], hollow=i % 2 == 1), name)
                  for i, name in enumerate(couplings)]
        page.figure(panels, "Each heap that was timed, at every rate and ratio: what 99 of 100 ticks and 9 of 10 global steps take "
                    "at most, of the time there is. Above the line it breaks: the tick by an overrun, the global step by a late "
                    "world.", legend + [(figure.key(ls=figure.LIMIT_DASHES), "all the time that there is")])


def capacity_page(data, page, what):
    page.answer(answer(data))
    page.text("A heap of cubes, all awake, that the hand's proxy stirs. Sustained: 99 of 100 ticks compute for less than the "
              "tick, and 9 of 10 global steps for less than their <i>ratio</i> ticks. CPU time, the least of up to "
              f"{data['runs']} identical runs, the global world {'on a core of its own' if data.get('two_cores') else 'on the same core'}; "
              f"the sub-world has at most {data['members']} members.")
    mine = [r for r in data["rows"] if all(r[key] == TARGET[key] for key in ("coupling", "rate_Hz", "ratio"))]
    if mine:
        row = mine[0]
        reached = row["bodies"] >= TARGET["bodies"]
        tried = reached or row["too_many"]
        page.head("Our target")
        page.table([Column("target", "of the sub-world at 1 kHz and ratio 10", "t"), Column("limit", "ours", "t"),
                    Column("measured", "the largest heap sustained", "t"), Column("verdict", "not tried: no heap so large was "
                                                                                  "timed", "t")],
                   [["cubes sustained", f"at least {count(TARGET['bodies'])}", count(row["bodies"]),
                     Cell("reached" if reached else "MISSED" if tried else "not tried",
                          "good" if reached else "bad" if tried else "")]])
    page.head("Bodies sustained")
    sustained_figure(data, page)
    page.head("What breaks, and where")
    load_figure(data, page)
    page.head("All figures")
    page.table([Column("coupling", "the scheme", "t"), Column("rate", "of the haptic loop, Hz"),
                Column("ratio", "ticks per global step"), Column("sustained", "the largest heap that is fast enough, cubes"),
                Column("too large", "the smallest that is not; –: none was found, cubes"),
                Column("times direct", "cubes over those of the direct coupling at this rate"),
                Column("breaks by", "what is too slow there", "t")],
               [[r["coupling"], exact(r["rate_Hz"]), r["ratio"], count(r["bodies"]), count(r["too_many"]) if r["too_many"] else
                 "–", number(r["times_direct"]) if is_number(r["times_direct"]) else "–", r["breaks_by"] or "–"]
                for r in data["rows"]])
    page.head("Each heap that was timed")
    page.table([Column("coupling", "the scheme", "t"), Column("rate", "Hz"), Column("ratio", "ticks per global step"),
                Column("cubes", "of the heap"), Column("contact points", "of the whole world"),
                Column("tick p50", "half of the ticks compute longer, µs"), Column("tick p99", "one of 100 does, µs"),
                Column("of the tick", "p99 over the tick's time"), Column("step p50", "half of the global steps take longer, µs; –: the direct coupling has none"),
                Column("step p90", "one of 10 does, µs"), Column("fits", "both are fast enough", "t")],
               [[p["coupling"], exact(p["rate_Hz"]), p["ratio"], count(p["bodies"]), count(p["contact_points"]),
                 number(p["tick_us_p50"]), number(p["tick_us_p99"]),
                 share(1e-6 * p["tick_us_p99"] * p["rate_Hz"]) if is_number(p["tick_us_p99"]) else "n/a",
                 *(number(p[k]) if p[k] else "–" for k in ("step_us_p50", "step_us_p90")), Cell("yes" if p["fits"] else "no", "" if p["fits"] else "bad")]
                for p in data["points"]])
