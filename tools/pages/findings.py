"""The sentences at the top of a page, computed from its data alone."""
from pages.parts import share, unique


def worst_of(rows, key):
    row = max(rows, key=lambda r: r[key])
    return f"{share(row[key])} ({row['scene']})"


def name_of(row):
    return row["coupling"] if row["border"] == "-" else f"{row['coupling']}, {row['border']}"


def of_windows(rows):
    """One sentence for each coupling and border, at the ratio 8 or the largest measured."""
    ratios = sorted(unique(r["ratio"] for r in rows if r["ratio"] > 1))
    if not ratios:
        return []
    ratio = 8 if 8 in ratios else ratios[-1]
    sentences = []
    for series in unique(name_of(r) for r in rows):
        mine = [r for r in rows if name_of(r) == series and r["ratio"] == ratio]
        if not mine:
            continue
        wild = [r["scene"] for r in mine if not r["stable"]]
        stable = "stable on all of them" if not wild else f"not stable on {', '.join(wild)}"
        sentences.append(f"<b>{series}</b>, windows at ratio {ratio}, {len(mine)} scenes: the force is off by at most "
                         f"{worst_of(mine, 'force_error_rms')}, at most {worst_of(mine, 'loss')} of the energy is lost "
                         f"and {worst_of(mine, 'gain')} gained; {stable}.")
    return sentences


def of_whole_runs(rows):
    """One sentence for each coupling and border, over all ratios and hands."""
    floor = [r for r in rows if r["started_apart_m"] > 0]
    sentences = []
    for series in unique(name_of(r) for r in rows if r["started_apart_m"] == 0):
        mine = [r for r in rows if name_of(r) == series and r["started_apart_m"] == 0]
        gain = worst_of([{**r, "gain": (r["energy_gain_J"] - r["direct_energy_gain_J"]) / r["energy_at_play_J"]}
                         for r in mine], "gain")
        fallen = unique(f"{r['scene']} at ratio {r['ratio']}" for r in mine if not r["stands"])
        felt = [r for r in mine if r["force_rms_N"] > 0]
        force = f"the force is off by at most {worst_of(felt, 'force_error')}" if felt else "nobody feels a force"
        stands = "every body stands" if not fallen else (f"{len(fallen)} of {len(unique((r['scene'], r['ratio']) for r in mine))} "
                                                         f"do not stand: {', '.join(fallen)}")
        sentences.append(f"<b>{series}</b>, whole runs of {mine[0]['seconds']:g} s at ratios "
                         f"{', '.join(str(n) for n in sorted(unique(r['ratio'] for r in mine)))}: {force}; "
                         f"{gain} of the energy at play is gained at most; {stands}.")
    felt = [r for r in floor if r["force_rms_N"] > 0]
    if felt:
        sentences.append(f"Two direct runs that start 1 &micro;m apart differ by at most {worst_of(felt, 'force_error')} "
                         "of the force: less cannot be told from chance.")
    return sentences


def of_costs(points):
    """What the default costs and buys, and what the front has beside it, by scene."""
    sentences = []
    for scene in unique(p["scene"] for p in points):
        mine = [p for p in points if p["scene"] == scene]
        default = next(p for p in mine if p["is_default"])
        front = [p for p in mine if p["on_front"]]
        best = min(front, key=lambda p: p["force_error_rms"])
        within = [p for p in front if p["force_error_rms"] <= default["force_error_rms"]]
        cheapest = min(within, key=lambda p: p["tick_us_p50"])
        words = ("no setting is as accurate and cheaper" if default["on_front"] else
                 f"as accurate for {cheapest['tick_us_p50']:.0f} us with {cheapest['sub_steps']} sub-steps, "
                 f"{cheapest['members']} members, ratio {cheapest['ratio']}, {cheapest['border']}")
        sentences.append(f"<b>{scene}</b>: the default's force is off by {share(default['force_error_rms'])} for a median "
                         f"tick of {default['tick_us_p50']:.0f} us; {words}. The most accurate, "
                         f"{share(best['force_error_rms'])}, takes {best['tick_us_p50']:.0f} us.")
    return sentences
