"""The page of `tactus experiment peers`: time beside quality, a panel for each scene."""
import html

from pages import figure, theme
from pages.numbers import count, is_number, listed, number, share, times, unit
from pages.page import Cell, Column
from pages.rows import unique


def own_rows(rows):
    return [r for r in rows if r["engine"] == "tactus"]


def answer(rows):
    compared = [r for r in own_rows(rows) if is_number(r["ratio_to_best_peer"])]
    left_out = [r["scene"] for r in own_rows(rows) if not is_number(r["ratio_to_best_peer"])]
    rest = f"; not compared: {listed(map(html.escape, left_out))}" if left_out else ""
    if not compared:
        return "No time of tactus can be compared: on no scene do both tactus and a peer pass the gates."
    low = min(compared, key=lambda r: r["ratio_to_best_peer"])
    high = max(compared, key=lambda r: r["ratio_to_best_peer"])
    faster = sum(r["ratio_to_best_peer"] < 1 for r in compared)
    spread = (f"{number(low['ratio_to_best_peer'])} times ({html.escape(low['scene'])})" if low is high else
              f"{number(low['ratio_to_best_peer'])} times ({html.escape(low['scene'])}) to {number(high['ratio_to_best_peer'])} "
              f"times ({html.escape(high['scene'])})")
    return (f"On this PC a step of tactus takes {spread} as long as one of the fastest peer that passes the gates, and is faster "
            f"on {faster} of {len(compared)} scenes{rest}.")


def engine_figure(rows, page):
    engines = unique(r["engine"] for r in rows)
    panels, numbered = [], {name: i for i, name in enumerate(engines)}
    for scene in unique(r["scene"] for r in rows):
        mine = [r for r in rows if r["scene"] == scene]
        x = figure.Scale([r["median_us"] for r in mine] + [r["p99_us"] for r in mine])
        y = figure.Scale([100 * r["penetration_mean_share"] for r in mine if is_number(r["penetration_mean_share"])], floor=1e-3,
                         cap=1000)
        panel = figure.Panel(scene, "time of a step [µs]", "mean overlap [% of a body]")
        x.apply(panel.axis, "x"), y.apply(panel.axis, "y")
        at = {}
        for r in mine:
            look = theme.style(numbered[r["engine"]])
            place, off = x.place(r["median_us"])
            high, off_y = y.place(times(r["penetration_mean_share"], 100))
            if place is None or high is None:
                panel.note(f"No finite number: {html.escape(r['engine'])}.")
                continue
            if off or off_y:
                panel.off_scale(r["engine"], [f"{unit(r['median_us'], 'µs')}, overlap {share(r['penetration_mean_share'])}"])
                panel.beyond([place], [high], look["color"])
                continue
            late = x.place(r["p99_us"])[0]
            if late is not None and late > place:
                panel.axis.plot([place, late], [high, high], color=look["color"], lw=1, alpha=0.6)
            panel.axis.plot([place], [high], ls="none", marker=look["marker"], ms=5.5, mec=look["color"],
                            mfc=look["color"] if r["is_compared"] else "none", gid=f"series {html.escape(r['engine'])}")
            at.setdefault((round(place, 3), round(high, 6)), []).append(r["engine"])
        for names in at.values():
            if len(names) > 1:
                panel.note(f"At the same place: {html.escape(', '.join(names))}.")
        panels.append(panel.drawn(f"{page.title} time"))
    legend = [(figure.key(**{**theme.style(i), "ls": None}), name) for i, name in enumerate(engines)]
    legend += [(figure.key(theme.MUTE, "o", hollow=True), "hollow: misses a gate, not compared in time"),
               (figure.key(theme.MUTE, ls="-"), "from the median to the 99th percentile of the steps")]
    page.figure(panels, "Time of a step against the mean overlap of the bodies: left and below is better.", legend)


def engines_page(data, page, what):
    rows = data["rows"]
    page.answer(answer(rows))
    sentences = []
    for r in own_rows(rows):
        scene = f"<b>{html.escape(r['scene'])}</b>"
        if is_number(r["ratio_to_best_peer"]):
            to_bullet = f", {number(r['ratio_to_bullet'])} times as long as Bullet at its defaults" if is_number(
                r["ratio_to_bullet"]) else ""
            sentences.append(f"{scene}: tactus takes {number(r['ratio_to_best_peer'])} times as long as the fastest peer that "
                             f"passes the gates{to_bullet}.")
        else:
            sentences.append(f"{scene}: no ratio, " + ("no peer passes the gates." if r["is_compared"] else
                             f"tactus fails: {html.escape(r['missed_gate'] or r['failure'])}."))
    page.findings(sentences)
    page.text("CPU time of one thread, the engines in turns. Overlaps are computed from the poses by tactus' collision "
              "functions, alike for every engine.")
    page.head("Time and overlap")
    engine_figure(rows, page)
    page.head("All figures")
    page.table([Column("scene", "the same bodies for every engine", "t"), Column("engine", "with its tuning", "t"),
                Column("median", "of the steps, µs"), Column("p99", "99 of 100 steps are shorter, µs"),
                Column("to Bullet", "median over that of Bullet at its defaults"),
                Column("to the best", "median over that of the fastest peer that passes"),
                Column("mean overlap", "of a body's deepest, mm"), Column("deepest", "mm"),
                Column("deepest, share", "of the thinner body"), Column("travel", "mean path of a body, m"),
                Column("rods", "path of the stirring rods, m"), Column("left", "bodies that left the box"),
                Column("gates", "pass, or what is missed", "w")],
               [[r["scene"], r["engine"], number(r["median_us"]), number(r["p99_us"]), number(r["ratio_to_bullet"]),
                 number(r["ratio_to_best_peer"]), number(times(r["penetration_mean_m"], 1e3)),
                 number(times(r["penetration_max_m"], 1e3)),
                 share(r["penetration_max_share"]), number(r["travel_m"]), number(r["rod_travel_m"]), count(r["escaped"]),
                 Cell(html.escape(r["missed_gate"] or r["failure"] or "pass"), "" if r["is_compared"] else "bad")] for r in rows])
    page.head("Settings")
    page.table([Column("scene", "of the rows above", "t"), Column("engine", "with its tuning", "t"),
                Column("settings", "what it was run with", "w")], [[r["scene"], r["engine"], r["settings"]] for r in rows])
