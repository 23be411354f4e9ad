"""Random worlds with a sub-world: the counts, and the worst worlds drawn from the side and from above."""
import html

import numpy as np
from matplotlib import ticker

from pages import figure, theme
from pages.numbers import count, exact, is_number, number, share
from pages.page import Column

SIDE, TOP = (0, 2), (0, 1)  # which two coordinates are drawn
MOMENTS = (("start", "start"), ("direct", "direct, end"), ("sub_world", "sub-world, end"))
FELL, PROXY, BODY = theme.SERIES[1], theme.SERIES[2], theme.SERIES[0]


def rotation(w, x, y, z):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def convex_hull(points):
    """Andrew 1979."""
    points = sorted(map(tuple, points))
    hull = []
    for run in (points, points[::-1]):
        part = []
        for p in run:
            while len(part) > 1 and ((part[-1][0] - part[-2][0]) * (p[1] - part[-2][1])
                                     - (part[-1][1] - part[-2][1]) * (p[0] - part[-2][0])) <= 0:
                part.pop()
            part.append(p)
        hull += part[:-1]
    return np.array(hull)


def outline(body, pose, view):
    """Outline of a convex body seen along an axis; none where the pose is not finite."""
    if any(v is None for v in pose):
        return None
    turn, view = rotation(*pose[3:]), list(view)
    if body["shape"] == "box":
        corners = [[s * h for s, h in zip(signs, body["half_m"])]
                   for signs in [(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]]
        points = (turn @ np.array(corners).T).T[:, view]
    else:
        axis, angle = turn[:, 2][view] * body["half_length_m"], np.linspace(0, 2 * np.pi, 48, endpoint=False)
        ring = body["radius_m"] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        points = np.concatenate([ring + axis, ring - axis])
    return convex_hull(points + np.array(pose[:3])[view])


def draw_world(axis, world, key, view, window):
    low, high = window
    for body in world["fixed"]:
        if body["shape"] != "plane":
            axis.fill(*outline(body, body["pose"], view).T, fc=theme.GRID, ec=theme.MUTE, lw=0.6)
        else:  # what lies behind it, where it is seen from its edge
            out = rotation(*body["pose"][3:])[:, 2][list(view)]
            if np.hypot(*out) > 0.99:
                at, along = np.array(body["pose"][:3])[list(view)], np.array([-out[1], out[0]])
                far = 10 * max(high[0] - low[0], high[1] - low[1]) + np.hypot(*(at - low))
                axis.fill(*np.array([at + far * along, at - far * along, at - far * along - far * out,
                                     at + far * along - far * out]).T, fc=theme.FILL, ec=theme.MUTE, lw=0.6, zorder=0)
    away = 0
    for body in world["bodies"]:
        points = outline(body, body[key], view)
        if points is None or (points.max(axis=0) < low).any() or (points.min(axis=0) > high).any():
            away += 1
            continue
        colour = FELL if body["fell"] else PROXY if body["id"] == 0 else BODY
        axis.fill(*points.T, fc=colour, alpha=0.15)
        axis.plot(*np.append(points, points[:1], axis=0).T, color=colour, lw=1.8 if body["fell"] else 1,
                  ls=(0, (3, 1)) if body["id"] == 0 else "-")
    axis.set_xlim(low[0], high[0]), axis.set_ylim(low[1], high[1])
    for line in (axis.xaxis, axis.yaxis):
        line.set_major_locator(ticker.MaxNLocator(nbins=5))
        line.set_major_formatter(ticker.FuncFormatter(lambda v, _: f"{v:.3g}"))
    axis.grid(False)
    return away


def window_of(world):
    """Middle and half size of what fell and the proxy, as direct coupling leaves them: what flies away must not shrink the
    rest to dots."""
    drawn = {view: np.concatenate([o for b in world["bodies"] if b["fell"] or b["id"] == 0 for key in ("start", "direct")
                                   if (o := outline(b, b[key], view)) is not None]) for view in (SIDE, TOP)}
    size = max(np.ptp(points, axis=0).max() for points in drawn.values())
    return {view: (points.min(axis=0) + points.max(axis=0)) / 2 for view, points in drawn.items()}, 1.2 * size


def world_panels(page, world):
    middle, size = window_of(world)
    panels = []
    for view, label, words in ((SIDE, "z [m]", "side"), (TOP, "y [m]", "above")):
        for key, title in MOMENTS:
            panel = figure.Panel(f"{title}, from the {words}" if view == SIDE else f"{title}, from {words}", "x [m]", label)
            panel.fig.set_size_inches(figure.WIDTH, figure.WIDTH * 0.99)
            panel.fig.subplots_adjust(left=0.2, right=0.94, bottom=0.15, top=0.89)  # square: a metre is as long on both axes
            panel.axis.set_aspect("equal", adjustable="box")
            away = draw_world(panel.axis, world, key, view, (middle[view] - size, middle[view] + size))
            if away:
                panel.note(f"{away} bod{'ies are' if away > 1 else 'y is'} outside of this window.")
            panels.append(panel.drawn(f"{page.title} {world['seed']}"))
    return panels


def off_words(world):
    return f"{number(world['off_share'])} of its smallest extent" if is_number(world["off_share"]) else "lost"


def answer(data):
    tried = data["worlds"] - len(data["left_out"])
    if tried <= 0:
        return "No random world was tried: none of those asked for can be made into a scene."
    fallen = f", {data['still_fallen']} of them by a body that stood still in the direct run" if data["collapsed"] else ""
    if data["overlapping"]:
        fallen += f", {data['overlapping']} of them in worlds whose bodies overlap by more than half at the start"
    return (f"{data['collapsed']} of {tried} random worlds collapse{'s' if data['collapsed'] == 1 else ''} with the sub-world at "
            f"ratio {data['ratio']} where the direct coupling leaves them standing{fallen}; {data['gain_energy']} "
            f"gain{'s' if data['gain_energy'] == 1 else ''} energy.")


def random_page(data, page, what):
    page.answer(answer(data))
    page.text(f"In {data['by_chance']} more a body falls that another direct run does not leave there either. Worlds by seed, from "
              f"{data['first']}, each with a hand for {exact(data['seconds'])} s: sub-world with ghosts beside direct coupling "
              "from the same start. A world collapses where a body falls that stands in three direct runs: the same, one that starts "
              "1 µm apart and one of twice as many sub-steps; what comes to rest there after a way counts too. "
              f"{data['with_border']} worlds have bodies outside of the sub-world; {count(data['standing_bodies'])} bodies stand in "
              f"the direct runs. Left out, since no scene file can be made of them: {len(data['left_out'])}.")
    if data["worst"]:
        page.head("The worst")
        legend = [(figure.key(FELL, ls="-"), "fell, or is off by more than half of its extent"),
                  (figure.key(PROXY, ls=(0, (3, 1))), "the hand's proxy"), (figure.key(BODY, ls="-"), "other bodies"),
                  (figure.key(theme.MUTE, ls="-"), "fixed")]
        for world in data["worst"]:
            page.figure(world_panels(page, world),
                        f"Seed {world['seed']}, {html.escape(world['outcome'])}: {world['members']} members; {len(world['fell'])} of "
                        f"{world['standing']} bodies that stand fell, the farthest is off by {off_words(world)}.", legend)
    page.head("What falls or gains energy")
    if not data["noted"]:
        page.text("Nothing.")
        return
    page.table([Column("seed", "of the world"), Column("outcome", "of the run with the sub-world", "t"),
                Column("fell", "bodies by number", "w"), Column("members", "of the sub-world, at most"),
                Column("standing", "bodies that stand in the direct run"), Column("off by", "the farthest body, of its smallest "
                                                                                  "extent"),
                Column("energy gained", "beyond the direct run, of the energy at play"),
                Column("force error", "RMS, of the direct coupling's force")],
               [[w["seed"], w["outcome"], ", ".join(map(str, w["fell"])) or "–", w["members"], w["standing"],
                 number(w["off_share"]) if is_number(w["off_share"]) else "lost", share(w["energy_gain_share"]),
                 share(w["force_error"])] for w in data["noted"]])
