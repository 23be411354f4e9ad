"""Short labels beside points, none on another or on a mark, and none outside of the axes."""

AWAY = (0, 4, 8, 14, 20)  # points from a mark to its label, the nearest first
SIDES = [(1, 1), (1, -1), (-1, 1), (-1, -1), (0, 1), (0, -1), (1, 0), (-1, 0)]
GAP = 1  # point: a browser's letters may be this much larger than those that are measured


def label_points(axis, labelled, own=0, size=7, marks=()):
    """labelled: (x, y, text) in data; own: radius of their marks; marks: (x, y, radius) of what else is drawn. Radii in points.
    Gives back the texts that found no room."""
    box = axis.get_window_extent()
    at = [axis.transData.transform((x, y)) for x, y, _ in labelled]
    around = [(x, y, own) for x, y in at] + [(*axis.transData.transform((x, y)), radius) for x, y, radius in marks]
    taken = [(x - radius, y - radius, x + radius, y + radius) for x, y, radius in around]
    left = []
    for (x, y), (in_data_x, in_data_y, text) in zip(at, labelled):
        label = axis.text(in_data_x, in_data_y, text, fontsize=size, ha="left", va="bottom", gid="label")
        drawn = label.get_window_extent()
        wide, high = drawn.width + 2 * GAP, drawn.height + 2 * GAP
        for away, (right, up) in ((away, side) for away in AWAY for side in SIDES):
            x0 = x + right * (own + away + wide / 2) - wide / 2
            y0 = y + up * (own + away + high / 2) - high / 2
            mine = (x0, y0, x0 + wide, y0 + high)
            if mine[0] < box.x0 or mine[2] > box.x1 or mine[1] < box.y0 or mine[3] > box.y1:
                continue
            if any(mine[0] < t[2] and t[0] < mine[2] and mine[1] < t[3] and t[1] < mine[3] for t in taken):
                continue
            taken.append(mine)
            label.set_position(axis.transData.inverted().transform((x0 + GAP, y0 + GAP)))
            break
        else:
            label.remove()
            left.append(text)
    return left
