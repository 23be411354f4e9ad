"""Random worlds with a sub-world: the counts, and the worst worlds drawn from the side and from above."""
import matplotlib.pyplot as plt
import numpy as np

from pages.parts import COLOURS, share

SIDE, TOP = (0, 2), (0, 1)  # which two coordinates are drawn
MOMENTS = (("start", "start"), ("direct", "direct, end"), ("sub_world", "sub-world, end"))


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
            axis.fill(*outline(body, body["pose"], view).T, fc="#dddddd", ec="#888", lw=0.6)
        else:  # what lies behind it, where it is seen from its edge
            out = rotation(*body["pose"][3:])[:, 2][list(view)]
            if np.hypot(*out) > 0.99:
                at, along = np.array(body["pose"][:3])[list(view)], np.array([-out[1], out[0]])
                far = 10 * max(high[0] - low[0], high[1] - low[1]) + np.hypot(*(at - low))
                axis.fill(*np.array([at + far * along, at - far * along, at - far * along - far * out,
                                     at + far * along - far * out]).T, fc="#eeeeee", ec="#888", lw=0.6, zorder=0)
    for body in world["bodies"]:
        points = outline(body, body[key], view)
        if points is None:
            continue
        colour = COLOURS[1] if body["fell"] else COLOURS[2] if body["id"] == 0 else COLOURS[0]
        axis.fill(*points.T, fc=colour, alpha=0.15)
        axis.plot(*np.append(points, points[:1], axis=0).T, color=colour, lw=1.6 if body["fell"] else 1)
    axis.set_xlim(low[0], high[0]), axis.set_ylim(low[1], high[1])
    axis.set_aspect("equal"), axis.grid(False), axis.tick_params(labelsize=7)


def window_of(world):
    """Middle and half size of what fell and the proxy, as direct coupling leaves them: what flies away must not shrink the
    rest to dots."""
    drawn = {view: np.concatenate([o for b in world["bodies"] if b["fell"] or b["id"] == 0 for key in ("start", "direct")
                                   if (o := outline(b, b[key], view)) is not None]) for view in (SIDE, TOP)}
    size = max(np.ptp(points, axis=0).max() for points in drawn.values())
    return {view: (points.min(axis=0) + points.max(axis=0)) / 2 for view, points in drawn.items()}, 0.75 * size


def world_figure(world):
    fig, axes = plt.subplots(2, 3, figsize=(9.6, 6.6), sharex=True, sharey="row", constrained_layout=True)
    middle, size = window_of(world)
    for row, view, name in zip(axes, (SIDE, TOP), ("z [m], from the side", "y [m], from above")):
        for axis, (key, title) in zip(row, MOMENTS):
            draw_world(axis, world, key, view, (middle[view] - size, middle[view] + size))
            if view == SIDE:
                axis.set_title(title, fontsize=10)
            else:
                axis.set_xlabel("x [m]")
        row[0].set_ylabel(name)
    return fig


def off_words(world):
    return "lost" if world["off_share"] is None else f"{world['off_share']:.3g}"


def random_page(data, page, what):
    page.findings([f"{data['collapsed']} of {data['worlds'] - len(data['left_out'])} random worlds collapse with the "
                   f"sub-world, {data['still_fallen']} of them by a body that stood still in the direct run; in {data['by_chance']} more a body falls that another direct run does not leave there "
                   f"either; {data['gain_energy']} gain energy."])
    page.text(f"Worlds by seed, from {data['first']}, each with a hand for {data['seconds']:g} s: sub-world with ghosts at "
              f"ratio {data['ratio']}, beside direct coupling from the same start. A world collapses where a body falls "
              "that stands in the direct run and in a second direct run that starts 1 &micro;m apart; what comes to rest there after a way counts too. "
              f"{data['with_border']} worlds have bodies outside of the sub-world; {data['standing_bodies']} bodies stand in "
              f"the direct runs. Left out, since no scene file can be made of them: {len(data['left_out'])}.")
    page.head("The worst")
    for world in data["worst"]:
        page.figure(world_figure(world),
                    f"Seed {world['seed']}, {world['outcome']}: {world['members']} members; {len(world['fell'])} of "
                    f"{world['standing']} bodies that stand fell (orange), the farthest is off by {off_words(world)} of its "
                    "smallest extent. Green: the proxy.")
    page.head("What falls or gains energy")
    page.table(["seed", "outcome", "bodies that fell", "members", "standing", "off, sizes", "energy gained", "force error"],
               [[w["seed"], w["outcome"], ", ".join(map(str, w["fell"])), w["members"], w["standing"], off_words(w),
                 "-" if w["energy_gain_share"] is None else share(w["energy_gain_share"]),
                 "-" if w["force_error"] is None else share(w["force_error"])] for w in data["noted"]])
