"""Short labels beside points, none on another or on a mark, and none outside of the axes."""

SIDES = [(6, 5), (6, -12), (-6, 5), (-6, -12), (0, 8), (0, -15), (12, -3), (-12, -3), (14, 10), (-14, 10), (14, -16), (-14, -16),
         (0, 18), (0, -25), (22, -3), (-22, -3), (22, 14), (-22, 14), (22, -20), (-22, -20)]


def label_points(axis, labelled, size=7, marks=()):
    """labelled: (x, y, text) in data; marks: (x, y, radius in points) of what else is drawn. Gives back the texts that found no
    room."""
    box = axis.get_window_extent()
    scale = axis.figure.dpi / 72
    at = [axis.transData.transform((x, y)) for x, y, _ in labelled]
    taken = [(x - 2 * scale, y - 2 * scale, x + 2 * scale, y + 2 * scale) for x, y in at]
    for x, y, radius in marks:
        x, y = axis.transData.transform((x, y))
        taken.append((x - radius * scale, y - radius * scale, x + radius * scale, y + radius * scale))
    left = []
    for (x, y), (_, _, text) in zip(at, labelled):
        wide, high = 0.7 * size * len(text) * scale, size * scale
        for dx, dy in SIDES:
            x0 = x + dx * scale - (wide if dx < 0 else wide / 2 if dx == 0 else 0)
            y0 = y + dy * scale
            mine = (x0, y0, x0 + wide, y0 + high)
            if mine[0] < box.x0 or mine[2] > box.x1 or mine[1] < box.y0 or mine[3] > box.y1:
                continue
            if any(mine[0] < t[2] and t[0] < mine[2] and mine[1] < t[3] and t[1] < mine[3] for t in taken):
                continue
            taken.append(mine)
            inverse = axis.transData.inverted().transform((x0, y0))
            axis.text(*inverse, text, fontsize=size, ha="left", va="bottom", gid="label")
            break
        else:
            left.append(text)
    return left
