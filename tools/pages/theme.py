"""How all pages look: colours by name, light, dark and printed, and matplotlib's drawings in these colours.

A drawing has no colour of its own: each that matplotlib writes is the name of a CSS variable, so that a page turns dark and
is printed light without being drawn again. Text stays text.
"""
import io
import re

import matplotlib.pyplot as plt

# name: (light, dark). Text and its paper are at least 4.5 : 1 apart, series and paper 3 : 1. The series' hues are those
# that people with any colour vision tell apart (Okabe, Ito 2008), darker or lighter where the paper asks for it.
COLOURS = {
    "paper": ("#ffffff", "#14171a"), "ink": ("#1a1a1b", "#e6e6e7"), "mute": ("#55595e", "#a9afb6"),
    "grid": ("#e2e4e7", "#33383e"), "fill": ("#f3f4f6", "#22272c"), "good": ("#006a4b", "#5fd3ab"),
    "bad": ("#b03a00", "#ff9a66"), "shade": ("#b4b9bf", "#6a727b"),
    "c0": ("#0067a5", "#5db5f2"), "c1": ("#c94f00", "#ff8d4d"), "c2": ("#00805d", "#3fcfa3"), "c3": ("#b3508b", "#f29ccb"),
    "c4": ("#8f6a00", "#eec044"), "c5": ("#3489bd", "#9ddbff"), "c6": ("#333437", "#cfd0d3"), "c7": ("#6b4fb3", "#b9a6ff"),
}
INK, MUTE, GRID, FILL, BAD = (COLOURS[name][0] for name in ("ink", "mute", "grid", "fill", "bad"))
SERIES = [COLOURS[f"c{i}"][0] for i in range(8)]
MARKS = ["o", "s", "^", "D", "v", "P", "X"]
DASHES = ["-", (0, (5, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)), (0, (3, 1, 1, 1, 1, 1))]
FACE = "'DejaVu Sans', Verdana, sans-serif"  # the widths by which matplotlib lays out
VARIABLE = {light: name for name, (light, _) in COLOURS.items()}

plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 8, "svg.fonttype": "none", "text.color": INK, "axes.edgecolor": MUTE,
    "axes.labelcolor": INK, "axes.titlecolor": INK, "xtick.color": INK, "ytick.color": INK, "xtick.labelsize": 8,
    "ytick.labelsize": 8, "axes.labelsize": 8, "axes.titlesize": 9, "axes.titlelocation": "left", "axes.facecolor": "none",
    "figure.facecolor": "none", "savefig.facecolor": "none", "axes.grid": True, "grid.color": GRID, "axes.axisbelow": True,
    "axes.spines.top": False, "axes.spines.right": False, "axes.unicode_minus": True, "lines.linewidth": 1.2,
    "figure.dpi": 72})  # SVG's: a pixel of the figure is a point


def style(i):
    """The look of series i: colour, mark and dash together, 35 before one comes again."""
    return {"color": SERIES[i % len(SERIES)], "marker": MARKS[i % len(MARKS)], "ls": DASHES[i % len(DASHES)]}


def css():
    def variables(which):
        return "".join(f"--{name}:{pair[which]};" for name, pair in COLOURS.items())
    return (f":root{{color-scheme:light dark;{variables(0)}}}"
            f"@media screen and (prefers-color-scheme:dark){{:root{{{variables(1)}}}}}" + STYLE)


STYLE = """
*{box-sizing:border-box}
body{font:15px/1.5 'DejaVu Sans',Verdana,sans-serif;max-width:72rem;margin:1.5rem auto;padding:0 12px;color:var(--ink);
background:var(--paper);overflow-wrap:anywhere}
h1{font-size:1.6rem;line-height:1.25;margin:.5rem 0}h2{font-size:1.2rem;margin:2rem 0 .5rem}
p,ul{max-width:52rem}ul{padding-left:1.2rem}
.answer{font-size:1.1rem;font-weight:bold}
code{background:var(--fill);padding:1px 4px}
.made{color:var(--mute);font-size:12px;margin:0 0 1rem}.made div{display:flex;gap:.5rem}
.made dt{flex:0 0 5rem}.made dd{margin:0}
figure{margin:1rem 0}figcaption,.note{color:var(--mute);font-size:13px;max-width:60rem}
.panels{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,340px),1fr));gap:4px 8px}
.panel svg{display:block;max-width:100%;height:auto}
.note{margin:0 0 .5rem;font-size:12px}
.legend{list-style:none;padding:0;margin:.3rem 0;display:flex;flex-wrap:wrap;gap:2px 16px;font-size:13px;max-width:none}
.legend li{display:flex;align-items:center;gap:6px}.legend svg{flex:none}
/* A table that scrolls has a shadow where more of it is: the covers move with the table, the shadows stay. */
.wide{overflow-x:auto;max-width:100%;background:linear-gradient(to right,var(--paper) 30%,transparent) 0/40px 100% local,
linear-gradient(to left,var(--paper) 30%,transparent) 100%/40px 100% local,
linear-gradient(to right,var(--shade),transparent) 0/14px 100% scroll,
linear-gradient(to left,var(--shade),transparent) 100%/14px 100% scroll;background-repeat:no-repeat}
table{border-collapse:collapse;font-size:12px;margin:.3rem 0;overflow-wrap:normal}
th,td{padding:2px 8px;text-align:right;border-bottom:1px solid var(--grid);vertical-align:top}
th{text-align:right;vertical-align:bottom}td{white-space:nowrap}
.t{text-align:left}td.w{white-space:normal;min-width:14rem;text-align:left}th.w{text-align:left}
td.good{color:var(--good)}td.bad{color:var(--bad);font-weight:bold}
.columns{font-size:12px;color:var(--mute);max-width:60rem;margin:.3rem 0 0}
.columns div{display:inline}.columns dt,.columns dd{display:inline;margin:0}.columns dt{font-weight:bold;color:var(--ink)}
.columns dd::after{content:"; "}.columns div:last-child dd::after{content:"."}
@media screen and (max-width:560px){.few{width:100%}.few thead{display:none}
.few tr{display:block;padding:4px 0;border-bottom:1px solid var(--grid)}
.few td,.few td.w{display:flex;gap:1rem;justify-content:space-between;border:0;padding:1px 0;min-width:0;white-space:normal;
text-align:right;overflow-wrap:anywhere}.few td::before{content:attr(data-head);color:var(--mute);text-align:left}}
@page{size:A4;margin:12mm}
@media print{body{margin:0;padding:0;max-width:none;font-size:10pt}.panels{grid-template-columns:1fr 1fr}.wide{overflow:visible}
table{font-size:7pt;width:auto}th,td{padding:1px 3px;white-space:normal}th,.t{overflow-wrap:anywhere}td.w{min-width:0}
.panel,.legend,figcaption,tr{break-inside:avoid}.legend{break-after:avoid}h2{break-after:avoid}}
"""


def svg_of(fig, salt, label):
    """The drawing as SVG for a page: colours by variables, no fixed ids but of its own definitions."""
    plt.rcParams["svg.hashsalt"] = salt  # own ids in each drawing, the same every time
    out = io.StringIO()
    fig.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Type": None, "Format": None})
    plt.close(fig)
    svg = out.getvalue()
    svg = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", svg[svg.index("<svg"):], flags=re.S)
    svg = re.sub(r"(fill|stroke): #000000; \1-opacity: 0", r"\1: none", svg)
    svg = re.sub(r"(fill|stroke): (#[0-9a-f]{6})", lambda m: f"{m[1]}: var(--{VARIABLE[m[2]]})", svg)
    svg = re.sub(r"'DejaVu Sans'(, sans-serif)?", FACE, svg)
    svg = re.sub(r'<g id="series ([^"]*)">', r'<g class="series" data-series="\1">', svg)
    svg = re.sub(r'<g id="matplotlib\.axis_\d+">', '<g class="axis">', svg)
    svg = re.sub(r'<g id="([a-zA-Z0-9]+)_\d+">', r'<g class="\1">', svg)
    return svg.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1)
