"""What the pages of all experiments have in common: the page itself, panels, words."""
import html
import io

import matplotlib.pyplot as plt
from matplotlib import ticker

# Colours that people with any colour vision tell apart (Okabe, Ito 2008).
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]  # one for each coupling
MARKS = ["o", "s", "^", "D", "v", "P", "X"]
plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.color": "#e5e5e5", "axes.axisbelow": True,
                     "axes.spines.top": False, "axes.spines.right": False, "svg.fonttype": "none",
                     "font.family": "sans-serif", "legend.frameon": False})


class Page:
    def __init__(self, title, command):
        self.title, self.command, self.parts, self.figures = title, command, [], 0

    def text(self, words):
        self.parts.append(f"<p>{words}</p>")

    def findings(self, sentences):
        """What comes out, before anything else; each sentence is markup."""
        items = "".join(f"<li>{s}</li>" for s in sentences)
        self.parts.append(f"<h2>What comes out</h2><ul>{items}</ul>")

    def head(self, words):
        self.parts.append(f"<h2>{html.escape(words)}</h2>")

    def figure(self, fig, caption):
        self.figures += 1
        plt.rcParams["svg.hashsalt"] = f"{self.title} {self.figures}"  # own ids in each drawing, the same every time
        out = io.StringIO()
        fig.savefig(out, format="svg", bbox_inches="tight", metadata={"Date": None})
        plt.close(fig)
        svg = out.getvalue()
        self.parts.append(f"<figure>{svg[svg.index('<svg'):]}<figcaption><b>Figure {self.figures}.</b> {caption} "
                          f"<code>{html.escape(self.command)}</code></figcaption></figure>")

    def table(self, heads, rows):
        cells = "".join(f"<th>{html.escape(h)}</th>" for h in heads)
        body = "".join("<tr>" + "".join(f"<td>{html.escape(str(c))}</td>" for c in row) + "</tr>\n" for row in rows)
        self.parts.append(f"<div class=wide><table><tr>{cells}</tr>\n{body}</table></div>")

    def write(self, path):
        style = ("body{font:15px/1.5 sans-serif;max-width:72em;margin:2em auto;padding:0 1em;color:#222}"
                 "figure{margin:2em 0}figcaption{color:#444;font-size:13px}svg{max-width:100%;height:auto}"
                 "table{border-collapse:collapse;font-size:12px}td,th{padding:2px 8px;text-align:right;"
                 "border-bottom:1px solid #e5e5e5}td{white-space:nowrap}td:nth-child(-n+3),th:nth-child(-n+3){text-align:left}"
                 ".wide{overflow-x:auto}code{background:#f3f3f3;padding:1px 4px}")
        with open(path, "w", encoding="utf-8") as out:
            out.write(f"<!doctype html><html lang=en><head><meta charset=utf-8><title>{html.escape(self.title)}</title>"
                      f"<style>{style}</style></head><body><h1>{html.escape(self.title)}</h1>\n"
                      f"<p>Every figure on this page comes from <code>{html.escape(self.command)}</code>.</p>\n")
            out.write("\n".join(self.parts) + "</body></html>\n")


def unique(values):
    return list(dict.fromkeys(values))


def panels(names, width=3.1, height=2.4):
    """A panel for each name, four in a row."""
    columns = min(4, len(names))
    lines = -(-len(names) // columns)
    fig, axes = plt.subplots(lines, columns, figsize=(width * columns, height * lines), squeeze=False,
                             constrained_layout=True)
    flat = [a for line in axes for a in line]
    for axis in flat[len(names):]:
        axis.set_visible(False)
    return fig, flat[:len(names)]


def plain_decades(axis):
    """2, 5, 10, 20 in place of powers, where a logarithmic axis spans little."""
    axis.set_major_formatter(ticker.FuncFormatter(lambda v, _: f"{v:g}"))
    axis.set_minor_locator(ticker.LogLocator(subs=(2, 5)))
    axis.set_minor_formatter(ticker.FuncFormatter(lambda v, _: f"{v:g}"))


def share(value):
    return f"{100 * value:.2f} %"


def worst(rows, key, limit, unit="%"):
    """(reached, words) of the largest value among the rows."""
    if not rows:
        return False, "not measured"
    row = max(rows, key=lambda r: r[key])
    value = share(row[key]) if unit == "%" else f"{row[key]:.4f} {unit}"
    return row[key] <= limit, f"{value} ({row['scene']})"
