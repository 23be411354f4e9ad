"""Small data for the pages, made by formulas, and with what no experiment should give: no numbers, one series far off the
scale, two alike, one point alone, long names, negative values and zeros where an axis is logarithmic."""
import copy
import random

MADE = {"date_utc": "2026-01-31 23:59 UTC", "version": "0.1.0 (commit 0123456789ab)", "built_for": "x86-64-v3 le",
        "machine": "a CPU with a long name of sixty-four cores @ 3.00GHz & <more>, 64 cores, Linux 6.1.0-rt",
        "command": "tactus experiment made --scenes a,b,c --ratios 1,2,4,8,16 --seeds 20 --page a-page-with-a-long-name.html"}

COUPLINGS = [("sub-world", b) for b in ("ghost", "capped", "replay", "filtered", "frozen")] + [
    (c, "-") for c in ("static", "interpolation", "plane", "planes", "linearised")]
LONG = "a_scene_that_has_a_name_of_more_than_sixty_characters_to_be_cut_off"


def window_row(scene, scheme, ratio, error, loss, gain):
    """`scheme`: coupling and border."""
    coupling, border = scheme
    return {"scene": scene, "coupling": coupling, "border": border, "ratio": ratio, "members": 10, "stiffness_N_per_m": 1500.0,
            "stiffness_Nm_per_rad": 4.0, "stiffness_lowered": ratio > 8, "loss": loss, "gain": gain, "force_error_rms": error,
            "sync_step_N": 0.3 * error, "hold_vibration_N": 0.01 * error, "stable": error < 0.5,
            "loss_worst_instant": 2 * loss, "gain_worst_instant": 2 * gain, "loss_speed_squared": loss,
            "gain_speed_squared": 4811.177356384313, "force_error_hold": error, "force_error_moving": error,
            "force_error_worst_window": 1.5 * error, "hold_vibration_worst_N": 0.02 * error,
            "hold_vibration_encoder_N": 0.03 * error, "energy_basis": "kinetic and spring", "loop_peak_N": 3.1,
            "loop_shake_N": 0.1, "loop_hold_N": 1.5, "loop_fallen": 0, "loop_energy_gain": 0.0,
            "by_seed": [{"force_error_rms": f * error, "loss": f * loss, "gain": f * gain, "sync_step_N": f * 0.3 * error,
                         "hold_vibration_N": f * 0.01 * error} for f in (0.5, 1.0, 2.0)],
            "spectrum_N2": [0.0] + [1e-6 * error / k for k in range(1, 101)]}


def window_scene(name):
    return {"scene": name, "bodies": 21, "members_cap": 10, "component": 21, "contact_points": 81, "contact_share": 1.0,
            "force_rms_N": 1.95, "apart_1um_force_error": 3e-4, "apart_1um_loss": 0.0, "apart_1um_gain": 5e-6,
            "loop_peak_N": 3.0, "loop_shake_N": 3.7e-15, "loop_hold_N": 2.7}


def whole_row(scene, ratio, apart=0.0, error=0.05, sub_steps=1):
    return {"scene": scene, "coupling": "sub-world", "border": "ghost", "ratio": ratio, "members": 10,
            "stiffness_N_per_m": 1500.0, "stiffness_Nm_per_rad": 4.0, "seconds": 10.0, "started_apart_m": apart, "sub_steps_times": sub_steps,
            "hand": "closed", "force_error": error, "force_error_by_quarter": [0.01, 0.02, 0.04, error], "force_rms_N": 2.0,
            "pose_off_m": 1e-4, "pose_off_most_m": 2e-3, "pose_off_share_of_size": 0.1, "drift_m": -1e-6, "deepest_m": 1e-5,
            "direct_deepest_m": 1e-5, "kinetic_J": 1e-3, "kinetic_over_work": 0.2, "energy_gain_J": 0.01,
            "direct_energy_gain_J": 0.02, "energy_at_play_J": 1.0, "border_work_J": -0.1, "fallen": 0, "stands": True}


def windows(scenes, couplings, ratios):
    rows = [window_row(scene, ("direct", "-"), 1, 0.0, 0.0, 0.0) for scene in scenes]
    rows += [window_row(scene, scheme, ratio, 0.001 * (i + 1) * ratio * (s + 1), 1e-5 * ratio * i, 1e-4 * i)
             for s, scene in enumerate(scenes) for i, scheme in enumerate(couplings) for ratio in ratios]
    return {"rows": rows, "scenes": [window_scene(s) for s in scenes], "whole": [], "seeds": 3, "windows_per_seed": 6,
            "window_cycles": 25, "window_least_s": 0.2, "spectrum_line_Hz": 5.0}


def awkward_windows():
    """Seven couplings with six borders in all, two alike, one far off the scale, one lost, in three scenes."""
    data = windows(["stack", LONG, "wall"], COUPLINGS, [1, 2, 4, 8, 16])
    alike = {}
    for row in data["rows"]:
        at = (row["scene"], row["ratio"])
        if row["coupling"] == "plane":
            alike[at] = row
        elif row["coupling"] == "planes":
            row.update({k: copy.deepcopy(v) for k, v in alike[at].items() if k not in ("coupling", "border")})
        elif row["coupling"] == "linearised" and row["ratio"] == 16:
            row.update(force_error_rms=314927889.7107, gain=3.1e6, sync_step_N=4e7, hold_vibration_N=1e6)
        elif row["coupling"] == "static" and row["ratio"] == 4:
            for key, value in row.items():
                if isinstance(value, float):
                    row[key] = None
            row["by_seed"] = [{key: None for key in seed} for seed in row["by_seed"]]
        elif row["border"] == "frozen":
            row["gain"] = -0.01
    whole = [whole_row(scene, ratio) for scene in ("stack", LONG) for ratio in (2, 8, 16)]
    whole += [whole_row("stack", 1, apart=1e-6, error=0.002),
              whole_row("stack", 1, sub_steps=2, error=0.004), whole_row("wall", 8, error=None)]
    whole[-1].update(energy_at_play_J=0.0, stands=False, fallen=3, pose_off_m=None)
    data["whole"] = whole
    return data


def cost_point(scene, i, **changed):
    point = {"scene": scene, "sub_steps": 4, "relax_sweeps": 1, "friction_sweeps": "relax", "contact_Hz": 250.0, "members": 64,
             "ratio": 8, "border": "ghost", "extraction": "best-first", "world_precision": "mixed",
             "force_error_rms": 0.02 / (1 + i), "force_error_by_seed": [0.01 / (1 + i), 0.03 / (1 + i)],
             "tick_us_p50_by_seed": [9.0 + 5 * i, 12.0 + 5 * i], "hold_vibration_N": 1e-4, "sync_step_N": 0.003, "loss": 0.0,
             "gain": 3.7e-5, "tick_us_p50": 10.123456 + 5 * i, "tick_us_p99": 26.45 + 5 * i, "tick_us_max": 90.0,
             "global_us_per_tick": 15.0, "instructions": None, "on_front": True, "is_default": i == 0}
    point.update(changed)
    return point


def notch(scene, factor, old, new, error, us):
    return {"scene": scene, "factor": factor, "from": old, "to": new, "error_before": 0.02, "error_after": error,
            "tick_us_before": 10.0, "tick_us_after": us, "global_us_before": 15.0, "global_us_after": 15.0163,
            "sentence": "of the terminal"}


def costs(scenes=("stack", "pile")):
    points = [p for s in scenes for p in (
        cost_point(s, 0), cost_point(s, 1, sub_steps=8), cost_point(s, 4, sub_steps=16, members=128),
        cost_point(s, 2, border="capped", on_front=False, force_error_rms=0.3),
        cost_point(s, 3, border="frozen", on_front=False, force_error_rms=0.1))]
    notches = [n for s in scenes for n in (
        notch(s, "sub-steps", "4", "8", 0.01, 15.0), notch(s, "sub-steps", "4", "16", 0.005, 700.0),
        notch(s, "members", "64", "32", 0.021, 7.0), notch(s, "members", "64", "128", 0.021, 7.0),
        notch(s, "border", "ghost", "capped", 0.3, 10.0), notch(s, "ratio", "8", "4", 0.02, 10.0))]
    return {"points": points, "notches": notches, "seeds": 2, "period_us": 1000.0, "budget_us": 600.0}


def awkward_costs():
    data = costs(("stack", LONG, "lost"))
    for point in data["points"]:
        if point["scene"] == "lost":  # nothing of it is a number
            point.update(force_error_rms=None, tick_us_p50=None, tick_us_p99=None, force_error_by_seed=[None], on_front=False)
    data["points"].append(cost_point("stack", 5, border="replay", on_front=False, force_error_rms=3e8, tick_us_p50=9e9))
    data["points"].append(cost_point("one", 0, force_error_by_seed=[], tick_us_p50_by_seed=[]))  # one point alone
    data["notches"] += [notch("stack", "border", "ghost", "replay", 3e8, 9e9), notch("stack", "border", "ghost", "x", None, 1.0)]
    return data


def crowded_costs(scenes=24):
    """Points, fronts and defaults wherever a measurement may put them; the same ones on each call."""
    chance, points = random.Random(19), []
    for scene in range(scenes):
        times = sorted(chance.uniform(10.0, 60.0) for _ in range(chance.randint(2, 14)))
        errors = sorted((10 ** chance.uniform(-3.5, -1.0) for _ in times), reverse=True)
        front = list(zip(times, errors))
        rest = [(us + chance.uniform(0.0, 4.0), error * 10 ** chance.uniform(0.0, 0.3)) for us, error in chance.choices(front, k=20)]
        default = chance.randint(0, len(front))  # on the front, or the first beside it
        points += [cost_point(f"scene {scene}", i, tick_us_p50=us, force_error_rms=error,
                              force_error_by_seed=[0.5 * error, 1.5 * error], tick_us_p50_by_seed=[us - 2.0, us + 2.0],
                              on_front=i < len(front), is_default=i == default)
                   for i, (us, error) in enumerate(front + rest)]
    return {"points": points, "notches": [], "seeds": 2, "period_us": 1000.0, "budget_us": 600.0}


def capacity():
    rows, points = [], []
    for rate in (1000.0, 4000.0):
        for i, coupling in enumerate(("direct", "sub-world", "static", "interpolation")):
            for ratio in (1,) if coupling == "direct" else (2, 10, 16):
                rows.append({"coupling": coupling, "rate_Hz": rate, "ratio": ratio, "bodies": 100 * ratio, "too_many": 120 * ratio,
                             "breaks_by": "global step", "times_direct": 1.0 * ratio})
                points += [{"coupling": coupling, "rate_Hz": rate, "ratio": ratio, "bodies": n, "contact_points": 5 * n,
                            "tick_us_p50": 0.5 * n, "tick_us_p99": 1.1 * n, "step_us_p50": 4.0 * n * (i > 0),
                            "step_us_p90": 5.0 * n * (i > 0), "fits": n < 800} for n in (25, 100, 400, 1600)]
    return {"rows": rows, "points": points, "members": 64, "runs": 5}


def awkward_capacity():
    data = capacity()
    data["rows"] = [r for r in data["rows"] if r["ratio"] in (1, 10) and r["rate_Hz"] == 1000]  # one ratio
    data["rows"][1].update(bodies=0, too_many=25, times_direct=None)  # the sub-world does not sustain the smallest heap
    data["rows"][2].update(bodies=400, too_many=None, breaks_by="")
    data["points"][0]["tick_us_p99"] = None
    data["points"][1]["tick_us_p99"] = 4e12
    return data


def stability():
    rows = []
    def add(factor, rate=1000.0, delay=1.0, jitter=0.0, quantum=0.0):
        for damping in (0.75, 6.0, 45.0, 150.0):
            rows.append({"factor": factor, "rate_Hz": rate, "delay_ticks": delay, "delay_s": delay / rate, "jitter_ticks": jitter,
                         "quantum_m": quantum, "damping_Ns_per_m": damping, "measured_N_per_m": 2 * damping * rate / delay,
                         "formula_N_per_m": damping * rate / delay, "line_N_per_m": 1.2 * damping * rate / delay,
                         "allowed_N_per_m": 0.56 * damping * rate / delay})
    add("rate"), add("rate", rate=4000.0), add("delay", delay=3.0), add("jitter", jitter=0.5), add("quantum", quantum=1.899e-5)
    return {"device": "virtuose6d", "rate_Hz": 1000.0, "rows": rows, "least_measured_over_formula": 2.0, "allowed_share": 0.56,
            "unsafe": 0, "wake": {"source": "1989 wake-ups of this PC", "degraded": True, "p50_us": 38.399, "p99_9_us": 1327.103,
                                  "max_us": 11376.772},
            "suggested": {"stiffness_N_per_m": 1429.9267403551432, "damping_Ns_per_m": 5.26582705873039,
                          "stiffness_Nm_per_rad": 5.138222718683614, "damping_Nms_per_rad": 0.018749319553847576}}


def awkward_stability():
    data = stability()
    data["rows"][3].update(measured_N_per_m=0.0, formula_N_per_m=0.0, line_N_per_m=3e9, allowed_N_per_m=0.0)
    data["rows"][5].update(measured_N_per_m=None)
    data["rows"][6].update(measured_N_per_m=5e12)
    data["suggested"]["stiffness_N_per_m"] = 0.0
    data["unsafe"] = 2
    return data


def peers():
    rows = []
    for s, scene in enumerate(("pile64", "pile1000-stirred")):
        for i, engine in enumerate(("tactus", "bullet", "bullet-tuned", "ode", "ode-tuned")):
            rows.append({"scene": scene, "engine": engine, "median_us": 50.0 * (i + 1) * (s + 1), "p99_us": 80.0 * (i + 1) * (s + 1),
                         "worst_over_median": 1.2, "contacts": 267.0, "touching_pairs": 67.0, "residual_speed_rms_m_per_s": 6e-5,
                         "penetration_mean_m": 4.5e-5, "penetration_mean_share": 4.5e-4 * (i + 1), "penetration_max_m": 7.9e-5,
                         "penetration_max_share": 7.9e-4, "travel_m": 9.06e-6, "rod_travel_m": 0.0, "escaped": 0,
                         "allocations_per_step": None, "ratio_to_bullet": 0.5 * (i + 1), "ratio_to_best_peer": 0.5 * (i + 1),
                         "is_compared": True, "settings": "double precision, 4 sub-steps, 1 relax sweep, contacts 250 Hz",
                         "missed_gate": "", "failure": ""})
    return {"rows": rows}


def awkward_peers():
    data = peers()
    data["rows"][0].update(ratio_to_best_peer=None, is_compared=False, missed_gate="the deepest overlap <25 %>")
    data["rows"][2].update(penetration_mean_share=None, median_us=None)
    data["rows"][3].update(penetration_mean_share=4e7, median_us=7e9, p99_us=9e9)
    data["rows"][6].update(penetration_mean_share=0.0)
    data["rows"][8].update(median_us=data["rows"][7]["median_us"], penetration_mean_share=data["rows"][7]["penetration_mean_share"])
    return data


def random_worlds():
    body = {"shape": "box", "half_m": [0.01, 0.02, 0.03], "id": 1, "fell": True, "start": [0.0, 0.0, 0.03, 1.0, 0.0, 0.0, 0.0],
            "direct": [0.0, 0.0, 0.03, 1.0, 0.0, 0.0, 0.0], "sub_world": [0.05, 0.0, 0.01, 0.7071, 0.0, 0.7071, 0.0]}
    proxy = {"shape": "capsule", "radius_m": 0.005, "half_length_m": 0.01, "id": 0, "fell": False,
             **{k: [0.0, 0.05, 0.05, 1.0, 0.0, 0.0, 0.0] for k in ("start", "direct", "sub_world")}}
    away = {**copy.deepcopy(body), "id": 2, "fell": False, "sub_world": [None] * 7, "direct": [900.0, 0, 0, 1, 0, 0, 0]}
    noted = {"seed": 3, "outcome": "collapses", "fell": [1], "still": [], "members": 2, "standing": 7, "fallen": 1, "lost": False,
             "start_overlap_share": 0.6, "off_share": 2.4717251340206805, "energy_gain_share": 0.02116820740923751, "force_error": 0.8099198820251405,
             "force_rms_N": 1.789278016686211}
    floor = {"shape": "plane", "pose": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]}
    return {"worlds": 20, "first": 0, "ratio": 8, "seconds": 5.0, "left_out": [11], "with_border": 19, "standing_bodies": 60,
            "collapsed": 1, "still_fallen": 0, "overlapping": 1, "by_chance": 2, "gain_energy": 0,
            "noted": [noted, {**noted, "seed": 4, "off_share": None, "energy_gain_share": None, "force_error": 3e9}],
            "worst": [{**noted, "bodies": [proxy, body, away], "fixed": [floor]}]}


# name: (experiment, data)
PAGES = {"couplings": ("couplings", lambda: windows(["stack", "pile"], COUPLINGS[:3], [2, 8, 16])),
         "couplings, awkward": ("couplings", awkward_windows),
         "energy-loss, one point": ("energy-loss", lambda: windows(["stack"], COUPLINGS[:1], [8])),
         "energy-loss, nothing but direct": ("energy-loss", lambda: windows(["stack"], [], [])),
         "accuracy-cost": ("accuracy-cost", costs), "accuracy-cost, awkward": ("accuracy-cost", awkward_costs),
         "accuracy-cost, crowded": ("accuracy-cost", crowded_costs),
         "capacity": ("capacity", capacity), "capacity, awkward": ("capacity", awkward_capacity),
         "stability-map": ("stability-map", stability), "stability-map, awkward": ("stability-map", awkward_stability),
         "peers": ("peers", peers), "peers, awkward": ("peers", awkward_peers), "random-worlds": ("random-worlds", random_worlds)}
