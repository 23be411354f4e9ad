// What is wrong with the page that is shown, one line each: "check: where and what". Run by tests/tools/pages/browser.py.
// arguments[0]: "page" of an experiment, or "plot", an SVG alone; [1]: the paper's colour that this medium must have.
const [kind, paper] = arguments;
const problems = [];
const bad = (check, words) => problems.push(`${check}: ${words}`);
const short = (text) => JSON.stringify(text.trim().replace(/\s+/g, ' ').slice(0, 60));
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const root = document.documentElement;
const drawings = kind === 'plot' ? [root] : all('figure svg[role=img]');

// Nothing is wider than the window; what scrolls on a screen does not scroll on paper.
if (root.scrollWidth > innerWidth && kind === 'page') bad('overflow', `the page is ${root.scrollWidth} px wide, the window ${innerWidth}`);
if (matchMedia('print').matches)
  for (const box of all('.wide'))
    if (box.scrollWidth > box.clientWidth + 1) bad('overflow', `printed, a table is ${box.scrollWidth} px wide of ${box.clientWidth}: ${short(box.textContent)}`);
// A table of few columns shows them all.
for (const table of all('table.few')) {
  const box = table.closest('.wide');
  if (box.scrollWidth > box.clientWidth + 1) bad('columns-hidden', `a table is ${box.scrollWidth} px wide of ${box.clientWidth}: ${short(box.textContent)}`);
}
if (kind === 'plot' && root.getBoundingClientRect().width > innerWidth) bad('overflow', 'the plot is wider than the window');

// Text lies within its drawing, nowhere on other text, and is large enough to be read.
const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0.5 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2;
for (const svg of drawings) {
  const box = svg.getBoundingClientRect();
  const texts = all('text', svg).map((t) => ({text: t.textContent, box: t.getBoundingClientRect(), size: parseFloat(getComputedStyle(t).fontSize) * t.getScreenCTM().a}));
  for (const t of texts) {
    if (t.box.left < box.left - 0.5 || t.box.right > box.right + 0.5 || t.box.top < box.top - 0.5 || t.box.bottom > box.bottom + 0.5)
      bad('clipped', `${short(t.text)} leaves its drawing`);
    if (Math.abs(t.size) > 0 && Math.abs(t.size) < 7) bad('small', `${short(t.text)} is ${t.size.toFixed(1)} px high`);
  }
  for (let i = 0; i < texts.length; ++i)
    for (let j = 0; j < i; ++j)
      if (overlap(texts[i].box, texts[j].box)) bad('overprint', `${short(texts[i].text)} lies on ${short(texts[j].text)}`);
  // A point's letter is on no point's mark, and beside one.
  const marks = all('use', svg).filter((mark) => !mark.closest('g.axis')).map((mark) => mark.getBoundingClientRect());
  for (const label of all('g[id=label] text', svg)) {
    const letter = label.getBoundingClientRect();
    if (marks.some((mark) => overlap(letter, mark))) bad('letter', `the letter ${short(label.textContent)} lies on a mark`);
    const apart = (a, b) => Math.max(a.left - b.right, b.left - a.right, a.top - b.bottom, b.top - a.bottom);
    if (marks.length && Math.min(...marks.map((mark) => apart(letter, mark))) > 0.12 * box.width)
      bad('far-letter', `the letter ${short(label.textContent)} is beside no mark`);
  }
}

// Axes: a unit on each; three ticks or more where the axis is of numbers, in order and evenly growing.
const value = (text) => {
  const plain = text.replace(/^≤ /, '').replace('all', '1').replace(/^1 in /, '').replace(/−/g, '-').replace(/[\u202f ]/g, '').replace(/^\+/, '');
  const up = '⁰¹²³⁴⁵⁶⁷⁸⁹';
  const power = plain.match(/^(-?)(?:([\d.]+)·)?10(⁻?)([⁰¹²³⁴⁵⁶⁷⁸⁹]+)$/);
  if (!power) return parseFloat(plain);
  const exponent = parseInt([...power[4]].map((c) => up.indexOf(c)).join(''), 10) * (power[3] ? -1 : 1);
  return (power[1] ? -1 : 1) * (power[2] ? parseFloat(power[2]) : 1) * 10 ** exponent;
};
const axes = [];
for (const svg of drawings) {
  if (kind === 'plot') {
    for (const which of ['x', 'y']) axes.push({which, label: all(`.${which}label`, svg)[0], ticks: all(`.${which}tick`, svg)});
    continue;
  }
  for (const axis of all('g.axis', svg)) {
    const which = axis.querySelector('g.xtick') ? 'x' : 'y';
    axes.push({which, label: [...axis.children].filter((c) => c.matches('g.text')).map((g) => g.querySelector('text'))[0],
               ticks: all('g.xtick text, g.ytick text', axis)});
  }
}
for (const {which, label, ticks} of axes) {
  const words = label ? label.textContent : '';
  if (!/\[[^\]]+\]/.test(words)) bad('units', `an axis says ${short(words)}`);
  const of_ratio = /^ratio/.test(words);
  if (ticks.length < (of_ratio ? 1 : 3)) bad('ticks', `${short(words)} has ${ticks.length}`);
  const at = ticks.map((t) => ({value: value(t.textContent), box: t.getBoundingClientRect()}))
                 .map((t) => ({value: t.value, at: which === 'x' ? (t.box.left + t.box.right) / 2 : -(t.box.top + t.box.bottom) / 2}))
                 .sort((a, b) => a.at - b.at);
  const down = /1 in N/.test(words);
  for (let i = 1; i < at.length; ++i)
    if (!(down ? at[i].value < at[i - 1].value : at[i].value > at[i - 1].value))
      bad('ticks', `${short(words)} goes from ${at[i - 1].value} to ${at[i].value}`);
}

// No series is hidden by another: none has the very line or the very marks of another one; each is in the legend.
for (const svg of drawings) {
  const seen = new Map();
  const legend = kind === 'plot' ? all('.key', svg).map((t) => t.textContent) : all('.legend span', svg.closest('figure')).map((s) => s.textContent);
  for (const series of all('[data-series]', svg)) {
    const name = series.dataset.series;
    if (!legend.includes(name)) bad('legend', `${short(name)} is drawn and not in it`);
    const shape = series.getAttribute('points') ||
        all('path', series).filter((p) => !p.closest('defs')).map((p) => p.getAttribute('d')).join(' ') +
        all('use', series).map((u) => `${u.getAttribute('x')},${u.getAttribute('y')}`).join(' ');
    if (!shape.trim()) continue;
    if (seen.has(shape) && seen.get(shape) !== name && !/At the same place/.test(svg.parentElement.textContent))
      bad('hidden', `${short(name)} lies on ${short(seen.get(shape))}`);
    seen.set(shape, name);
  }
}

// Colours: text is 4.5 : 1 or more against its paper, series 3 : 1; the paper is that of the medium.
const rgb = (colour) => { const m = colour.match(/rgba?\(([^)]+)\)/); return m ? m[1].split(',').map(Number) : null; };
const luminance = ([r, g, b]) => {
  const line = [r, g, b].map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * line[0] + 0.7152 * line[1] + 0.0722 * line[2];
};
const contrast = (a, b) => { const [x, y] = [luminance(a), luminance(b)].sort((p, q) => q - p); return (x + 0.05) / (y + 0.05); };
const paper_of = (element) => {
  for (let e = element; e; e = e.parentElement) {
    const colour = rgb(getComputedStyle(e).backgroundColor);
    if (colour && (colour.length < 4 || colour[3] > 0)) return colour;
  }
  return [255, 255, 255];
};
const ground = kind === 'plot' ? root : document.body;
if (getComputedStyle(ground).backgroundColor !== paper) bad('paper', `is ${getComputedStyle(ground).backgroundColor}, not ${paper}`);
const walker = document.createTreeWalker(ground, NodeFilter.SHOW_TEXT);
const told = new Set();
for (let node = walker.nextNode(); node; node = walker.nextNode()) {
  const element = node.parentElement, text = node.textContent;
  if (!text.trim() || element.closest('style, script, title')) continue;
  const look = getComputedStyle(element);
  const colour = rgb(element.closest('svg') ? look.fill : look.color);
  const ratio = colour ? contrast(colour, paper_of(element)) : 0;
  const key = `${look.color} ${look.fill} ${element.tagName}`;
  if (ratio < 4.5 && !told.has(key)) { told.add(key); bad('contrast', `${short(text)} has ${ratio.toFixed(2)} : 1`); }
  // Numbers: no more than four digits that mean something beside a point, six in all; none that is no number.
  if (element.closest('code, .made')) continue;
  for (const digits of text.replace(/(\d)\u202f(?=\d)/g, '$1').match(/\d+(?:\.\d+)?/g) || []) {
    const meaning = digits.replace('.', '').replace(/^0+/, '');
    if (meaning.length > (digits.includes('.') ? 4 : 6)) bad('digits', `${digits} in ${short(text)}`);
  }
  if (/(^|[^\w])(nan|inf|None|null|undefined|Infinity)([^\w]|$)/.test(text)) bad('digits', `no number in ${short(text)}`);
}
for (const series of all('[data-series]')) {
  const drawn = series.matches('polyline') ? series : all('path, use', series).find((e) => !e.closest('defs'));
  if (!drawn) continue;
  const look = getComputedStyle(drawn);
  const colour = rgb(look.stroke) || rgb(look.fill);
  if (colour && contrast(colour, paper_of(ground)) < 3) bad('contrast', `series ${short(series.dataset.series)} has ${contrast(colour, paper_of(ground)).toFixed(2)} : 1`);
}

// What the page opens with, and that it needs nothing else.
const date = /\d{4}-\d\d-\d\d \d\d:\d\d UTC/;
if (kind === 'page') {
  const answers = all('.answer'), sentence = answers.length ? answers[0].textContent.trim() : '';
  if (answers.length !== 1 || answers[0].previousElementSibling?.tagName !== 'H1') bad('answer', 'is not what the page opens with');
  if (sentence.length < 30 || !/^[A-Z0-9].*\.$/s.test(sentence)) bad('answer', short(sentence));
  const made = all('.made dd').map((d) => d.textContent.trim());
  if (answers[0]?.nextElementSibling?.className !== 'made' || made.length !== 5 || made.some((m) => !m) || !date.test(made[0]))
    bad('provenance', short(made.join('; ')));
  for (const table of all('table')) {
    const explained = table.closest('.wide').nextElementSibling;
    const words = explained?.matches('dl.columns') ? all('dt', explained).map((d) => d.textContent) : [];
    for (const head of all('th', table)) if (!words.includes(head.textContent)) bad('columns', `${short(head.textContent)} is not explained`);
  }
} else {
  for (const line of all('.answer, .made').slice(0, -1))
    if (/(^| )[\d.]+$/.test(line.textContent) && line.nextElementSibling?.getAttribute('class') === line.getAttribute('class'))
      bad('unit', `${short(line.textContent)} ends between a number and what follows it`);
  const stroke = (selector) => { const e = root.querySelector(selector); return e ? rgb(getComputedStyle(e).stroke) : null; };
  const limit = stroke('.limit');
  for (const series of all('[data-series]')) {
    const colour = rgb(getComputedStyle(series).stroke);
    const apart = limit && colour ? Math.hypot(...[0, 1, 2].map((i) => limit[i] - colour[i])) : 0;
    if (apart < 100) bad('limit', `the deadline has nearly the colour of ${short(series.dataset.series)}`);
  }
  const sentence = all('.answer').map((t) => t.textContent).join(' '), made = all('.made').map((t) => t.textContent).join(' ');
  if (sentence.length < 30 || !sentence.endsWith('.')) bad('answer', short(sentence));
  if (!date.test(made) || !['version: ', 'machine: ', 'command: '].every((word) => made.includes(word))) bad('provenance', short(made));
}
for (const element of all('[src], [href], [*|href], link, script'))
  if (!/^#/.test(element.getAttribute('href') || element.getAttribute('xlink:href') || '')) bad('network', short(element.outerHTML));
for (const style of all('style')) if (/url\(|@import/.test(style.textContent)) bad('network', 'a style asks for a file');
return problems;
