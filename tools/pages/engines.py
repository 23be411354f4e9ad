"""The page of `tactus experiment peers`: time beside quality, a panel for each scene."""
from pages.parts import COLOURS, MARKS, panels, unique


def engines_page(data, page, what):
    rows = data["rows"]
    scenes, engines = unique(r["scene"] for r in rows), unique(r["engine"] for r in rows)
    sentences = []
    for r in rows:
        if r["engine"] == "tactus" and r["ratio_to_best_peer"]:
            sentences.append(f"<code>{r['scene']}</code>: tactus takes {r['ratio_to_best_peer']:.3f} times as long as the fastest "
                             "peer that passes the gates.")
        elif r["engine"] == "tactus":
            sentences.append(f"<code>{r['scene']}</code>: no ratio, " + (
                "no peer passes the gates." if r["is_compared"] else f"tactus fails: {r['missed_gate'] or r['failure']}."))
    page.findings(sentences)
    page.text("CPU time of one thread, the engines in turns. Overlaps are computed from the poses by tactus' collision "
              "functions, alike for every engine. A hollow mark misses a gate and is not compared in time.")
    page.head("Time and overlap")
    fig, axes = panels(scenes, 3.6, 3.0)
    for axis, scene in zip(axes, scenes):
        axis.set_title(scene)
        axis.set_xscale("log")
        axis.set_xlabel("median step [us]")
        axis.set_ylabel("mean overlap [% of a body]")
        for i, engine in enumerate(engines):
            for r in (r for r in rows if r["scene"] == scene and r["engine"] == engine):
                colour = COLOURS[i % len(COLOURS)]
                axis.plot([r["median_us"]], [100 * r["penetration_mean_share"]], linestyle="", color=colour,
                          marker=MARKS[i % len(MARKS)], markerfacecolor=colour if r["is_compared"] else "none",
                          label=engine if scene == scenes[0] else None)
    axes[0].legend(fontsize=7)
    page.figure(fig, "Median time of a step against the mean overlap.")
    page.head("All figures")
    page.table(["scene", "engine", "settings", "median us", "p99 us", "to Bullet", "to the best", "mean overlap mm",
                "deepest mm", "deepest %", "travel m", "rods' m", "left the box", "gates"],
               [[r["scene"], r["engine"], r["settings"], f"{r['median_us']:.1f}", f"{r['p99_us']:.1f}",
                 f"{r['ratio_to_bullet']:.3f}" if r["ratio_to_bullet"] else "-",
                 f"{r['ratio_to_best_peer']:.3f}" if r["ratio_to_best_peer"] else "-",
                 f"{1e3 * r['penetration_mean_m']:.3f}", f"{1e3 * r['penetration_max_m']:.2f}",
                 f"{100 * r['penetration_max_share']:.1f}", f"{r['travel_m']:.3f}", f"{r['rod_travel_m']:.3f}",
                 r["escaped"], r["missed_gate"] or r["failure"] or "pass"] for r in rows])
