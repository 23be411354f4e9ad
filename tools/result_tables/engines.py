"""Time of a step beside other engines, at every size, and what was asked of it."""
from result_tables.border import rows_of, tactus
from result_tables.parts import Table
from result_tables.words import markdown, overlap_mm, three

PEERS = "experiment peers --scenes {scenes} --runs {runs}"
NAMES = {"bullet": "Bullet", "ode": "ODE", "mujoco": "MuJoCo"}


def step_of(scene):
    return "1 ms" if scene.startswith("pile64") else "10 ms"


def us(value):
    return f"{value:,.0f}"


def setting_of(engine):
    """'bullet-tuned-4': Bullet, tuned, 4 iterations; 'ode': ODE at its defaults."""
    name, *rest = engine.split("-")
    iterations = [f"{word} iterations" for word in rest if word.isdigit()]
    return ", ".join([NAMES[name], *(["tuned", *iterations] if rest else ["defaults"])])


def cell_of(row, words):
    """A row that fails says why in place of its time."""
    return words if not (row["failure"] or row["missed_gate"]) else f"{us(row['median_us'])}, fails: {row['failure'] or row['missed_gate']}"


def engines_of(rows, scene):
    return {r["engine"]: r for r in rows if r["scene"] == scene}


def best_of(of_scene):
    passed = [r for name, r in of_scene.items() if name != "tactus" and r["is_compared"]]
    return min(passed, key=lambda r: r["median_us"], default=None)


def ratio_to(row, other):
    return three(row["median_us"] / other["median_us"]) if other and row["is_compared"] and other["is_compared"] else "-"


def peers_row(scene, of_scene):
    own, best, bullet = of_scene["tactus"], best_of(of_scene), of_scene.get("bullet")
    three_rows = (own, best, bullet)

    def side(key, text):
        return " / ".join(text(r[key]) if r else "-" for r in three_rows)

    if not bullet:
        default = "-"
    elif best is bullet:
        default = "the same"
    else:
        default = cell_of(bullet, f"{us(bullet['median_us'])} ({ratio_to(own, bullet)})")
    return [f"`{scene}`", step_of(scene), cell_of(own, us(own["median_us"])),
            f"{us(best['median_us'])}: {setting_of(best['engine'])}" if best else "none passes", ratio_to(own, best), default,
            side("penetration_mean_m", overlap_mm), side("penetration_max_m", overlap_mm),
            side("travel_m", lambda m: f"{m:.2f}") if "stirred" in scene else "at rest"]


def peers(done):
    rows = rows_of(done)
    head = ["scene", "step", "tactus, µs", "best peer that passes, µs", "ratio to it", "Bullet at its defaults, µs (ratio)",
            "mean overlap, mm: tactus / best / Bullet", "deepest, mm", "travel, m"]
    return markdown(head, [peers_row(scene, engines_of(rows, scene)) for scene in dict.fromkeys(r["scene"] for r in rows)])


# Every peer where its steps take minutes at most; of the largest heaps two runs would take hours.
PEER_RUNS = {"pile64": (2, "", 2), "pile64-stirred": (2, "", 2), "pile1000": (2, "", 3), "pile1000-stirred": (2, "", 4),
             "pile5000-stirred": (1, "tactus,bullet,bullet-tuned-40,ode-tuned-40", 6), "pile10000-stirred": (1, "tactus,bullet", 3),
             "hulls1000": (1, "tactus,bullet,bullet-tuned-40,ode,ode-tuned,ode-tuned-40", 5),
             "shapes1000": (1, "tactus,bullet,bullet-tuned-40,ode,ode-tuned,ode-tuned-40", 5),
             **{scene: (1, "tactus,bullet,bullet-tuned-40,ode,ode-tuned-40", 4)
                for scene in ("hulls1000-stirred", "hulls1000-8-stirred", "hulls1000-64-stirred", "shapes1000-stirred", "terrain1000")}}


def peer_parts(_base):
    return [tactus(scene, PEERS.format(scenes=scene, runs=runs) + (f" --peers {names}" if names else ""), minutes)
            for scene, (runs, names, minutes) in PEER_RUNS.items()]


# --- larger heaps, at rest

LARGER = {"pile5000": (2, 3), "pile10000": (1, 4), "mixed10000": (2, 3)}  # runs, minutes
ASKED = {"pile5000": " (0.10)"}


def larger_parts(_base):
    return [tactus(scene, PEERS.format(scenes=scene, runs=runs) + " --peers tactus,bullet", minutes)
            for scene, (runs, minutes) in LARGER.items()]


def larger(done):
    rows, table = rows_of(done), []
    for scene in dict.fromkeys(r["scene"] for r in rows):
        own, bullet = (engines_of(rows, scene)[name] for name in ("tactus", "bullet"))
        table.append([f"`{scene}`", step_of(scene), cell_of(own, us(own["median_us"])), cell_of(bullet, us(bullet["median_us"])),
                      ratio_to(own, bullet) + ASKED.get(scene, ""),
                      f"{own['residual_speed_rms_m_per_s']:.0e} ({bullet['residual_speed_rms_m_per_s']:.0e})",
                      f"{overlap_mm(own['penetration_max_m'])} ({overlap_mm(bullet['penetration_max_m'])})"])
    return markdown(["scene", "step", "median of tactus, µs", "of Bullet", "ratio (asked)", "residual speed, m/s (Bullet)",
                     "deepest overlap, mm (Bullet)"], table)


# --- what was asked

GOALS = {"at-rest": ("experiment peers --scenes pile64,pile1000 --peers tactus,bullet --runs 9", 2),
         "pile5000-rests": ("experiment peers --scenes pile5000 --peers tactus --runs 1", 1),
         "pile5000": ("run sim/scenes/pile5000.toml --duration 10", 0.4),
         "heaps50k": ("run sim/scenes/heaps50k.toml --duration 10", 0.4),
         "scaling": ("experiment scaling", 6),
         "stirred": ("experiment peers --scenes pile64-stirred,pile1000-stirred,hulls1000-stirred,shapes1000-stirred,terrain1000"
                     " --peers tactus --runs 5", 1),
         "capacity": ("experiment capacity --rates 1000 --ratios 10 --couplings sub-world", 3)}


def goal_parts(_base):
    return [tactus(name, command, minutes) for name, (command, minutes) in GOALS.items()]


def step_times(data):
    world = data["global_world"]
    late = f"; {world['late_cycles']} of {world['cycles']} cycles late; of the loop's ticks {data['timing']['overruns_own_work']} late by its own work"
    return f"step p50 {world['step']['p50_us'] / 1e3:.1f}, p99 {world['step']['p99_us'] / 1e3:.1f} ms of 10{late}"


def worst_words(data):
    return ", ".join(f"`{r['scene']}` {r['engine']} {r['worst_over_median']:.2f}" for r in data["rows"])


def stirred_tick_words(data):
    """Of the members' ticks in the largest heap that is sustained."""
    most = max((p for p in data["points"] if p["fits"]), key=lambda p: p["bodies"])
    return f"{us(most['tick_us_p99'])} µs ({data['members']} members of {most['bodies']:,} cubes)"


def sizes_words(rows):
    """Of the broad phase: the widest range of sizes beside equal ones."""
    sizes = {r["size_ratio"]: r["broad_phase_us"] for r in rows if r["sweep"] == "sizes"}
    most, least = max(sizes), min(sizes)
    return f"{sizes[most] / sizes[least]:.1f} times ({us(sizes[most])} and {us(sizes[least])} µs), settled"


def rests_words(rows):
    return ", ".join(f"`{r['scene']}` {r['residual_speed_rms_m_per_s']:.0e} m/s" for r in rows if r["engine"] == "tactus")


def goals(done):
    """A goal whose parts are not measured yet is left out."""
    data = {one.part.name: one.data for one in done}
    rows = []

    def goal(asked, names, words):
        if all(name in data for name in names):
            rows.append([asked, words(*(data[name] for name in names))])

    goal("every step at rest costs the same: worst over median at most 1.05", ["at-rest"],
         lambda rest: f"{worst_words(rest)} (nine runs)")
    goal("stirred: worst over median at most 1.3", ["stirred"], lambda stirred: f"{worst_words(stirred)} (five runs)")
    goal("at least 7,500 cubes awake and stirred, ratio 10, 1 kHz, one core", ["capacity"],
         lambda data: f"{data['rows'][0]['bodies']:,}; more break by {data['rows'][0]['breaks_by']}")
    goal("64 stirred members: p99 of a tick's computation at most 120 µs", ["capacity"], stirred_tick_words)
    goal("5,000 cubes awake, ratio 10, 1 kHz, in real time", ["pile5000"], step_times)
    goal("50,000 bodies, most asleep", ["heaps50k"], step_times)
    goal("cost linear from 100 to 100,000 contacts", ["scaling"],
         lambda s: f"time to the power {s['exponent']:.2f} of the contact points"
                   + (f", instructions {s['instruction_exponent']:.2f}" if s["instruction_exponent"] else ""))
    goal("sizes 1:20, 10,000 bodies: broad phase at most 3 times that of equal sizes", ["scaling"], lambda s: sizes_words(s["rows"]))
    goal("a settled heap rests", ["at-rest", "pile5000-rests"], lambda small, large: rests_words(small["rows"] + large["rows"]))
    return markdown(["asked", "now"], rows)


TABLES = {
    "peers": Table(f"`tactus {PEERS.format(scenes='SCENE', runs=2)}`, scene by scene; rows but `pile64`, `pile1000` and these stirred with "
                   "`--runs 1` and the `--peers` that tools/result_tables/engines.py names", "25 min", peer_parts, peers),
    "larger-heaps": Table(f"`tactus {PEERS.format(scenes='SCENE', runs=2)} --peers tactus,bullet`, scene by scene; `pile10000` with `--runs 1`",
                          "5 min", larger_parts, larger),
    "goals": Table("; ".join(f"`tactus {command}`" for command, _ in GOALS.values()), "10 min, of it 20 s in real time", goal_parts, goals),
}
