// Reads what is needed of XML: elements, their attributes, the line where each begins and the text that it takes up.
//
// Document type declarations are refused: no entity but XML's own five is ever expanded. Bounds: kMaxDepth, kMaxElements.
export const kMaxDepth = 200, kMaxElements = 200_000;

const kName = /[\w:.-]+/y, kMark = /[<>"']/g;

export class Mistake extends Error {}

// The elements of a text, in their order: {name, attributes, line, begin, end, depth, parent (its number, or -1)}.
export function read_elements(text, file) {
  const elements = [], open = [];
  let at = 0, line = 1, counted = 0;
  const line_of = (place) => {
    for (; counted < place; ++counted) if (text.charCodeAt(counted) === 10) ++line;
    return line;
  };
  const skip_to = (mark, from) => {
    const found = text.indexOf(mark, from);
    if (found < 0) throw new Mistake(`${file}:${line_of(from)}: XML ends where ${mark} is awaited; accepted: well-formed XML`);
    return found + mark.length;
  };
  for (;;) {
    const begin = text.indexOf("<", at);
    if (begin < 0) break;
    if (text.startsWith("<!--", begin)) at = skip_to("-->", begin);
    else if (text.startsWith("<![CDATA[", begin)) at = skip_to("]]>", begin);
    else if (text.startsWith("<?", begin)) at = skip_to("?>", begin);
    else if (text.startsWith("<!", begin))
      throw new Mistake(`${file}:${line_of(begin)}: a document type declaration; accepted: XML without one`);
    else if (text.startsWith("</", begin)) {
      at = skip_to(">", begin);
      if (open.length === 0) throw new Mistake(`${file}:${line_of(begin)}: an element ends that has not begun`);
      elements[open.pop()].end = at;
    } else {
      kName.lastIndex = begin + 1;
      const name = kName.exec(text)?.[0], close = name === undefined ? -1 : end_of_head(text, kName.lastIndex);
      if (close < 0) throw new Mistake(`${file}:${line_of(begin)}: no XML element; accepted: well-formed XML`);
      const head = text.slice(kName.lastIndex, close);
      at = close + 1;
      const attributes = {};
      for (const found of head.matchAll(/([\w:.-]+)\s*=\s*(?:"([^"]*)"|'([^']*)')/g))
        attributes[found[1]] = plain(found[2] ?? found[3]);
      const closed = head.trimEnd().endsWith("/");
      elements.push({name, attributes, line: line_of(begin), begin, end: at, depth: open.length,
                     parent: open.at(-1) ?? -1, file});
      if (elements.length > kMaxElements) throw new Mistake(`${file}: more than ${kMaxElements} elements`);
      if (!closed) open.push(elements.length - 1);
      if (open.length > kMaxDepth) throw new Mistake(`${file}:${line}: elements nested deeper than ${kMaxDepth}`);
    }
  }
  if (open.length > 0)
    throw new Mistake(`${file}:${elements[open.at(-1)].line}: <${elements[open.at(-1)].name}> is not closed`);
  return elements;
}

// Where the ">" is that ends an element's head, outside of quotes; -1: nowhere.
function end_of_head(text, from) {
  for (let at = from;;) {
    kMark.lastIndex = at;
    const mark = kMark.exec(text);
    if (mark === null || mark[0] === "<") return -1;
    if (mark[0] === ">") return mark.index;
    const end = text.indexOf(mark[0], mark.index + 1);
    if (end < 0) return -1;
    at = end + 1;
  }
}

function plain(text) {
  const known = {lt: "<", gt: ">", amp: "&", quot: '"', apos: "'"};
  return text.replace(/&(\w+);/g, (whole, name) => known[name] ?? whole);
}
