"""Whole runs on the page of `energy-loss` and `couplings`: from rest, beside the windows."""
import html
import math

from pages import figure, theme
from pages.numbers import exact, is_number, number, share, times
from pages.page import Cell, Column
from pages.rows import NOTICED, name_of, unique, worst_words


def gained(row):
    energies = [row[key] for key in ("energy_gain_J", "direct_energy_gain_J", "energy_at_play_J")]
    return (energies[0] - energies[1]) / energies[2] if all(map(is_number, energies)) and energies[2] > 0 else math.nan


def direct_twin(row):
    """The words for a second direct run; None for a run of a coupling."""
    if row["started_apart_m"] > 0:
        return "1 µm apart"
    return f"{row['sub_steps_times']} × sub-steps" if row["sub_steps_times"] > 1 else None


def unknown_scenes(rows):
    """{scene: the largest force error of another direct run}, where a hand would notice it: those judge no coupling."""
    found = {}
    for r in rows:
        if direct_twin(r) is not None and is_number(r["force_error"]):
            found[r["scene"]] = max(found.get(r["scene"], 0.0), r["force_error"])
    return {scene: error for scene, error in found.items() if error >= NOTICED}


def whole_sentences(rows):
    """One for each coupling and border, over all ratios and hands; one of the scenes that judge none."""
    sentences = []
    coupled = [r for r in rows if direct_twin(r) is None]
    unknown = unknown_scenes(rows)
    for name in unique(name_of(r, False) for r in coupled):
        mine = [r for r in coupled if name_of(r, False) == name]
        felt = [r for r in mine if is_number(r["force_rms_N"]) and r["force_rms_N"] > 0 and r["scene"] not in unknown]
        fallen = unique(f"{html.escape(r['scene'])} at ratio {r['ratio']}" for r in mine if not r["stands"])
        runs = len(unique((r["scene"], r["ratio"]) for r in mine))
        sentences.append(
            f"<b>{html.escape(name)}</b>, whole runs of {exact(mine[0]['seconds'])} s: "
            + (f"the force is off by {worst_words(felt, 'force_error', bound=True)}" if felt else "nobody feels a force")
            + f"; gained of the energy at play: {worst_words([{**r, 'gained': gained(r)} for r in mine], 'gained', bound=True)}; "
            + (f"bodies fall in {len(fallen)} of {runs}: {', '.join(fallen)}." if fallen else "every body stands."))
    if unknown:
        sentences.append("The forces above leave out scenes whose direct run another direct run does not repeat within "
                         f"{share(NOTICED)}: " + ", ".join(f"{html.escape(scene)} ({share(error)})"
                                                            for scene, error in unknown.items()) + ".")
    return sentences


def whole_runs(rows, page):
    page.head(f"Whole runs of {exact(rows[0]['seconds'])} s")
    page.text("From rest, with the scene's own hand. One run each: no spread.")
    tested = [r for r in rows if direct_twin(r) is None and r["hand"] == "closed"]
    several = len(unique((r["scene"], r["members"]) for r in tested)) > len(unique(r["scene"] for r in tested))
    names = unique(name_of(r, several) for r in tested)
    ratios = sorted(unique(r["ratio"] for r in tested))
    index_of = {name: i for i, name in enumerate(names)}
    twins = [r for r in rows if direct_twin(r) is not None]
    scale = figure.Scale([times(r["force_error"], 100) for r in tested + twins], floor=0.01, cap=1000,
                         also=[100 * NOTICED], far=math.inf)
    panels = []
    for scene in unique(r["scene"] for r in tested):
        panel = figure.Panel(scene, "ratio [ticks per global step]", "force error [%]")
        panel.line(100 * NOTICED, "7 %")
        for r in twins:
            if r["scene"] == scene and is_number(r["force_error"]):
                panel.line(scale.place(100 * r["force_error"])[0], direct_twin(r), ls=figure.FLOOR_DASHES)
        series = {}
        for r in (r for r in tested if r["scene"] == scene):
            value = times(r["force_error"], 100)
            series.setdefault(name_of(r, several), {})[r["ratio"]] = (value, None, None, not r["stands"])
        figure.stepped(panel, ratios, series, scale, lambda v: share(v / 100), index_of)
        panels.append(panel.drawn(f"{page.title} whole"))
    legend = figure.series_keys(names) + [(figure.key(theme.INK, "x"), "a body does not stand at the end"),
                                          (figure.key(ls=figure.LIMIT_DASHES), "7 %: a hand notices"),
                                          (figure.key(ls=figure.FLOOR_DASHES), "the direct run beside one that starts 1 µm apart, and beside one of finer steps")]
    if panels:
        page.figure(panels, "Force error over the whole run, RMS(F − F<sub>direct</sub>) / RMS(F<sub>direct</sub>), the hand in "
                    "the run's own loop.", legend)
    page.table([Column("scene", "the world", "t"), Column("coupling", "the scheme; 1 µm apart: a direct run whose proxy starts "
                                                          "1 µm aside; 2 × sub-steps: a direct run of as many", "t"),
                Column("border", "how members feel the outside", "t"), Column("ratio", "haptic ticks per global step"),
                Column("members", "cap of the sub-world"), Column("hand", "closed: its arm in the loop of the run; direct: the "
                                                                  "arm's motion of the direct run; none: no device", "t"),
                Column("force error", "over the whole run"), Column("by quarter", "of the run, each over the whole run's force, in %"),
                Column("off at end", "the farthest body from where the direct run has it, mm"), Column("off at most", "the same at any synchronisation, mm"),
                Column("drift", "off at end, less the same at three quarters, mm"), Column("kinetic / work", "kinetic energy over the hand's work and the potential energy that was released"),
                Column("energy gained", "beyond the direct run, of the energy at play"), Column("stands", "every body, at the end")],
               [[r["scene"], direct_twin(r) or r["coupling"], r["border"], r["ratio"], r["members"],
                 r["hand"], share(r["force_error"]), " / ".join(share(q).replace(" %", "") for q in r["force_error_by_quarter"]),
                 number(times(r["pose_off_m"], 1e3)), number(times(r["pose_off_most_m"], 1e3)), number(times(r["drift_m"], 1e3)),
                 number(r["kinetic_over_work"]), share(gained(r)),
                 "yes" if r["stands"] else Cell(f"NO, {r['fallen']} fell", "bad")] for r in rows])
