"""A page: the sentence that answers its question, where its figures come from, then parts in order."""
import html

from pages import theme


MOST_STACKED = 6  # columns of a table whose rows are cards in a narrow window; a wider one is scrolled


class Column:
    """Of a table: its head, what it means, and how its cells stand: "n" numbers, "t" words, "w" words that wrap."""

    def __init__(self, head, meaning, kind="n"):
        self.head, self.meaning, self.kind = head, meaning, kind


class Cell:
    """Markup in a table, with the verdict that colours it: "good", "bad" or none."""

    def __init__(self, markup, verdict=""):
        self.markup, self.verdict = markup, verdict


class Page:
    def __init__(self, title, made):
        self.title, self.made, self.parts, self.figures, self.sentence = title, made, [], 0, ""

    def answer(self, markup):
        """The first sentence, computed from the page's data."""
        self.sentence = markup

    def text(self, markup):
        self.parts.append(f"<p>{markup}</p>")

    def findings(self, sentences):
        if sentences:
            self.head("What comes out")
            self.parts.append("<ul>" + "".join(f"<li>{s}</li>" for s in sentences) + "</ul>")

    def head(self, words):
        self.parts.append(f"<h2>{html.escape(words)}</h2>")

    def figure(self, panels, caption, legend=()):
        """Panels side by side as far as the window is wide; each is (markup of its drawing, notes)."""
        self.figures += 1
        drawn = "".join(f'<div class="panel">{svg}' + "".join(f'<p class="note">{n}</p>' for n in notes) + "</div>"
                        for svg, notes in panels)
        keys = "".join(f"<li>{swatch}<span>{html.escape(label)}</span></li>" for swatch, label in legend)
        keys = f'<ul class="legend">{keys}</ul>' if keys else ""
        self.parts.append(f'<figure>{keys}<div class="panels">{drawn}</div><figcaption><b>Figure {self.figures}.</b> '
                          f"{caption}</figcaption></figure>")

    def table(self, columns, rows):
        def cell(column, content):
            classes = " ".join(c for c in ({"n": "", "t": "t", "w": "t w"}[column.kind], getattr(content, "verdict", "")) if c)
            markup = content.markup if isinstance(content, Cell) else html.escape(str(content))
            named = f' class="{classes}"' if classes else ""
            return f'<td{named} data-head="{html.escape(column.head)}">{markup}</td>'
        heads = "".join(f'<th scope="col" class="{"" if c.kind == "n" else "t"}">{html.escape(c.head)}</th>' for c in columns)
        body = "\n".join("<tr>" + "".join(cell(c, x) for c, x in zip(columns, row)) + "</tr>" for row in rows)
        words, meanings = "", []  # columns in a row that mean the same are explained together
        for c in columns:
            if meanings and meanings[-1][1] == c.meaning:
                meanings[-1][0].append(c.head)
            else:
                meanings.append(([c.head], c.meaning))
        for named, meaning in meanings:
            words += "<div>" + ", ".join(f"<dt>{html.escape(n)}</dt>" for n in named) + f" <dd>{meaning}</dd></div> "
        few = ' class="few"' if len(columns) <= MOST_STACKED else ""
        self.parts.append(f'<div class="wide" tabindex="0"><table{few}><thead><tr>{heads}</tr></thead>\n<tbody>{body}</tbody></table>'
                          f'</div><dl class="columns">{words}</dl>')

    def made_by(self):
        entries = [("date", "date_utc"), ("version", "version"), ("built for", "built_for"), ("machine", "machine")]
        lines = "".join(f"<div><dt>{word}</dt><dd>{html.escape(self.made[key])}</dd></div>" for word, key in entries)
        command = html.escape(self.made["command"])
        return f'<dl class="made">{lines}<div><dt>command</dt><dd><code>{command}</code></dd></div></dl>'

    def write(self, path):
        title = html.escape(self.title)
        with open(path, "w", encoding="utf-8") as out:
            out.write('<!doctype html><html lang="en"><head><meta charset="utf-8">'
                      '<meta name="viewport" content="width=device-width,initial-scale=1">'
                      f"<title>{title}</title><style>{theme.css()}</style></head><body><h1>{title}</h1>\n"
                      f'<p class="answer">{self.sentence}</p>\n{self.made_by()}\n')
            out.write("\n".join(self.parts) + "</body></html>\n")
