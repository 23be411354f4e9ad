"""The border between the two worlds: windows, members, whole runs, the scenes of tests/border, random worlds."""
import tomllib

from result_tables.parts import ROOT, Part, Table, run_json
from result_tables.words import digits, markdown, percent

BORDERS = ("ghost", "capped", "replay", "filtered", "frozen")


def tactus(name, command, minutes):
    return Part(name, ("tactus", *command.split()), minutes, run_json)


def rows_of(done, key="rows"):
    return [row for one in done for row in one.data[key]]


def force_off(row):
    return percent(row["force_error_rms"]) + ("" if row["stable"] else ", unstable")


def too_much(row):
    return percent(row["gain"]) + ("*" if "spring" in row["energy_basis"] else "")


# --- windows, of each scene by each border

WINDOWS = "experiment energy-loss --seeds 2 --ratios 8,16"
WINDOW_SCENES = ("stack", "card-house", "pile", "press", "peg", "chain", "wall")


def window_parts(_base):
    return [tactus(scene, f"{WINDOWS} --scenes {scene}", 0.5 if scene == "pile" else 0.1) for scene in WINDOW_SCENES]


def windows(done):
    head = ["scene", *(f"force off: `{b}`" for b in BORDERS), *(f"energy too much: `{b}`" for b in BORDERS),
            "force off at 16: `ghost`", "energy too much at 16: `ghost`"]
    rows = []
    for scene in dict.fromkeys(r["scene"] for r in rows_of(done)):
        at = {(r["ratio"], r["border"]): r for r in rows_of(done) if r["scene"] == scene}
        rows.append([scene, *(force_off(at[8, b]) for b in BORDERS), *(too_much(at[8, b]) for b in BORDERS),
                     force_off(at[16, "ghost"]), too_much(at[16, "ghost"])])
    return markdown(head, rows)


# --- the pile by its number of members

MEMBERS = "experiment energy-loss --scenes pile --borders ghost --ratios 8,16"
CAPS = (8, 16, 32, 64, 128)


def member_parts(_base):
    return [tactus(f"members-{cap}", f"{MEMBERS} --members {cap}", 2) for cap in CAPS]


def members(done):
    rows, all_rows = [], rows_of(done)
    caps = sorted({r["members"] for r in all_rows})
    for name, key in (("force off", "force_error_rms"), ("energy too much", "gain")):
        for ratio in sorted({r["ratio"] for r in all_rows}):
            by_cap = {r["members"]: r for r in all_rows if r["ratio"] == ratio}
            rows.append([f"{name} at ratio {ratio}", *(percent(by_cap[c][key]) for c in caps)])
    return markdown(["members of the pile's sub-world", *caps], rows)


# --- the coupling schemes beside each other

COUPLINGS = "experiment couplings --seeds 2 --ratios 8,16 --borders ghost"
COUPLING_RATIOS = (8, 16)


def coupling_parts(_base):
    return [tactus(scene, f"{COUPLINGS} --scenes {scene}", 2) for scene in WINDOW_SCENES]


def couplings(done):
    schemes = [name for name in dict.fromkeys(r["coupling"] for r in rows_of(done)) if name != "direct"]
    rows = []
    for scene in dict.fromkeys(r["scene"] for r in rows_of(done)):
        at = {(r["coupling"], r["ratio"]): r for r in rows_of(done) if r["scene"] == scene}
        rows.append([scene, *(" / ".join(force_off(at[scheme, ratio]) if (scheme, ratio) in at else "-" for ratio in COUPLING_RATIOS)
                              for scheme in schemes)])
    return markdown(["scene", *(f"`{scheme}`" for scheme in schemes)], rows)


# --- whole runs

WHOLE = "experiment energy-loss --quick --seeds 0 --whole {seconds} --scene {scene} --members {members} --ratios {ratios} --borders ghost"
WHOLE_RATIOS = (2, 4, 8, 10, 16)
SECONDS = 30
NO_DIRECT_RUN = ("pile700", "pile5000", "heaps50k")  # direct coupling takes hours for them
HEAVY = ("press", "pile250", "wall", "tower", "crib", "plate_on_balls")


def scene_files():
    return [file for folder in ("tests/border", "sim/scenes") for file in sorted((ROOT / folder).glob("*.toml"))
            if file.stem not in NO_DIRECT_RUN]


def three_caps(file):
    """The scene's number of members, half of it and a quarter; two members at least."""
    whole = tomllib.loads(file.read_text(encoding="utf-8"))["simulation"]["members"]
    return list(dict.fromkeys(max(2, whole // share) for share in (1, 2, 4)))


def whole_parts(_base, ratios=WHOLE_RATIOS, others=""):
    parts = []
    for file in scene_files():
        caps = three_caps(file)
        command = WHOLE.format(seconds=SECONDS, scene=file.relative_to(ROOT), members=",".join(map(str, caps)),
                               ratios=",".join(map(str, ratios))) + others
        parts.append(tactus(file.stem, command, (0.005 if file.stem in HEAVY else 0.001) * SECONDS * len(caps) * len(ratios)))
    return parts


def coupled_runs(done, hand="closed"):
    """The sub-world's runs with that hand, by scene and cap: {ratio: row}."""
    found = {}
    for row in rows_of(done, "whole"):
        if row["coupling"] == "sub-world" and row["hand"] == hand:
            found.setdefault((row["scene"], row["members"]), {})[row["ratio"]] = row
    return found


def uncertainty(done, key):
    """By scene, the largest `key` of its other direct runs: one that starts 1 um aside, one with twice the sub-steps."""
    found = {}
    for row in rows_of(done, "whole"):
        if row["coupling"] != "sub-world" and row[key] is not None:
            found[row["scene"]] = max(found.get(row["scene"], 0.0), row[key])
    return found


def whole_cells(runs):
    """What one cap did, from the force to who stands. Ratios that the scene refuses are '-'."""
    given = [runs.get(ratio) for ratio in WHOLE_RATIOS]
    felt = any(r and r["force_rms_N"] for r in given)
    force = ", ".join(digits(100 * r["force_error"]) if r else "-" for r in given) if felt else "no force"
    off = ", ".join(f"{1e3 * r['pose_off_m']:.2f}" if r else "-" for r in given)
    shares = [r["pose_off_share_of_size"] for r in given if r and r["pose_off_share_of_size"] is not None]
    fallen = [str(ratio) for ratio, r in zip(WHOLE_RATIOS, given) if r and not r["stands"]]
    gain = max((r["energy_gain_J"] - r["direct_energy_gain_J"]) / r["energy_at_play_J"] for r in given if r)
    spent = max(r["border_spent_share"] for r in given if r)
    return (force, off, f"{100 * max(shares):.1f} %" if shares else "-", f"{100 * max(0.0, gain):.2f}", f"{100 * spent:.1f}",
            "NO at " + ", ".join(fallen) if fallen else "yes")


def whole(done):
    """Caps with the same cells are one row."""
    by_cells, direct = {}, uncertainty(done, "force_error")
    poses = uncertainty(done, "pose_off_share_of_size")
    for (scene, cap), runs in coupled_runs(done).items():
        by_cells.setdefault((scene, whole_cells(runs)), []).append(cap)
    rows = [[f"{scene}, {' or '.join(map(str, sorted(caps, reverse=True)))}", force,
             "-" if force == "no force" or scene not in direct else digits(100 * direct[scene]), off, of_size,
             f"{100 * poses[scene]:.1f} %" if scene in poses else "-", *others]
            for (scene, (force, off, of_size, *others)), caps in by_cells.items()]
    return markdown(["scene, members", "force, %", "of direct itself, %", "off, mm", "of its size", "of direct itself",
                     "energy too much, %", "tank empty, %", "stands"], rows)


# --- whole runs without a hand

ALONE = " --hands none"
ALONE_RATIOS = (8, 16)


def alone(done):
    """Caps with the same cells are one row."""
    by_cells = {}
    for (scene, cap), runs in coupled_runs(done, "none").items():
        given = list(runs.values())
        if not given[0]["energy_at_play_J"]:  # weightless
            continue
        at_play_J = given[0]["energy_at_play_J"]
        share = lambda runs, key: ", ".join(f"{100 * r[key] / at_play_J:.3f}" for r in runs)
        fallen = [str(r["ratio"]) for r in given if not r["stands"]]
        cells = (f"{at_play_J:.3g}", share(given, "energy_unexplained_J"), share(given[:1], "direct_energy_unexplained_J"),
                 share(given, "energy_rise_J"), share(given[:1], "direct_energy_rise_J"), "NO at " + ", ".join(fallen) if fallen else "yes")
        by_cells.setdefault((scene, cells), []).append(cap)
    ratios = ", ".join(map(str, ALONE_RATIOS))
    return markdown(["scene, members", "energy at play, J", f"unexplained at ratio {ratios}, %", "of direct, %", "rises, %",
                     "of direct, %", "stands"],
                    [[f"{scene}, {' or '.join(map(str, sorted(caps, reverse=True)))}", *cells] for (scene, cells), caps in by_cells.items()])


# --- the scenes of tests/border

BORDER_RATIOS = (2, 8, 16)
BORDER_CAPS = {"two_cubes": (2,), "stack20_foot": (10, 2), "pull_bottom": (6, 2), "table": (6, 3, 2), "seesaw": (4, 2), "crib": (16, 4),
               "plate_on_balls": (16, 4), "portal": (4, 2), "heavy": (4, 2), "block_row": (4, 2), "pyramid_top": (4, 2), "hit": (4, 2),
               "hanging": (4, 2), "pendulum_cut": (4, 3, 2), "thousand": (6, 2), "cradle": (3, 2), "knock": (2,), "billiard": (4, 2), "drop": (3, 2), "tray": (4, 2), "whip": (5, 2)}
BORDER = "experiment energy-loss --seeds 0 --whole 20 --scene tests/border/{scene}.toml --members {members} --ratios 2,8,16 --borders ghost"
FORCE_THAT_IS_FELT = 0.05


def border_parts(_base):
    return [tactus(scene, BORDER.format(scene=scene, members=",".join(map(str, caps))), (0.7 if scene in HEAVY else 0.15) * len(caps))
            for scene, caps in BORDER_CAPS.items()]


def border_force(row):
    text = f"{100 * row['force_error']:.1f}" if row["force_error"] < 0.0995 else f"{100 * row['force_error']:.0f}"
    return f"**{text}**" if row["force_error"] > FORCE_THAT_IS_FELT else text


def border_scenes(done):
    rows = []
    for (scene, cap), runs in coupled_runs(done).items():
        given = [runs[ratio] for ratio in BORDER_RATIOS if ratio in runs]
        felt = any(r["force_rms_N"] for r in given)
        fallen = [str(r["ratio"]) for r in given if not r["stands"]]
        rows.append([f"{scene}, {cap}", ", ".join(map(border_force, given)) + " %" if felt else "no force",
                     ", ".join(f"{1e3 * r['pose_off_m']:.2f}" for r in given) + " mm", "NO at " + ", ".join(fallen) if fallen else "yes"])
    ratios = ", ".join(map(str, BORDER_RATIOS))
    return markdown(["scene, members", f"force at ratio {ratios}", f"off at ratio {ratios}", "stands"], rows)


# --- random worlds

WORLDS, AT_A_TIME = 10000, 100
RANDOM = "experiment hard-cases --random {worlds} --first {first} --sub-world"


def random_parts(_base):
    return [tactus(f"from-{first:05}", RANDOM.format(worlds=AT_A_TIME, first=first), 1.2) for first in range(0, WORLDS, AT_A_TIME)]


def random_worlds(done):
    total = {key: sum(one.data[key] for one in done) for key in
             ("worlds", "with_border", "standing_bodies", "collapsed", "overlapping", "still_fallen", "by_chance", "gain_energy")}
    left_out = sum(len(one.data["left_out"]) for one in done)
    falls = ("collapses", "collapses: what stood still falls")
    seeds = [str(trial["seed"]) for trial in rows_of(done, "noted") if trial["outcome"] in falls]
    rows = [["worlds", total["worlds"]],
            ["of them no scene file can say", left_out],
            ["run", total["worlds"] - left_out],
            ["of these with a border", total["with_border"]],
            ["bodies that stand in the direct runs", total["standing_bodies"]],
            ["worlds that collapse", total["collapsed"]],
            ["of these start with bodies that overlap by more than half", total["overlapping"]],
            ["of all that collapse, a body falls that was at rest", total["still_fallen"]],
            ["seeds of those that collapse and do not overlap so", ", ".join(seeds) or "none"],
            ["worlds where a body falls by chance", total["by_chance"]],
            ["worlds that gain energy", total["gain_energy"]]]
    return markdown(["", "number"], [[name, f"{n:,}" if isinstance(n, int) else n] for name, n in rows])


TABLES = {
    "windows": Table(f"`tactus {WINDOWS}`, scene by scene", "2 min", window_parts, windows),
    "members": Table(f"`tactus {MEMBERS} --members {','.join(map(str, CAPS))}`, cap by cap", "10 min", member_parts, members),
    "couplings": Table(f"`tactus {COUPLINGS}`, scene by scene", "15 min", coupling_parts, couplings),
    "whole": Table(f"`tactus {WHOLE.format(seconds=SECONDS, scene='FILE', members='DEFAULT,HALF,QUARTER', ratios='2,4,8,10,16')}`, "
                   "scene by scene", "30 min", whole_parts, whole),
    "alone": Table(f"`tactus {WHOLE.format(seconds=SECONDS, scene='FILE', members='DEFAULT,HALF,QUARTER', ratios='8,16')}{ALONE}`, "
                   "scene by scene", "12 min", lambda base: whole_parts(base, ALONE_RATIOS, ALONE), alone),
    "border-scenes": Table(f"`tactus {BORDER.format(scene='SCENE', members='MEMBERS')}`, scene by scene", "10 min", border_parts,
                           border_scenes),
    "random-worlds": Table(f"`tactus {RANDOM.format(worlds=WORLDS, first=0)}`, {AT_A_TIME} worlds at a time",
                           "2 h on one core; --workers shares it", random_parts, random_worlds),
}
