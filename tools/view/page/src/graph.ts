// The contact graph, as in the paper's Fig. 2: the proxy at the top, bodies in layers by contacts from it. Members are
// filled, the border is ringed, an edge is as thick as the force in it. Of the bodies outside those are shown that touch
// a member, hollow, and the proxy of another hand, filled and ringed.
import { kindOf, kLegend, kPointedAt } from "./scene3d";
import { Role } from "./wire";
import type { World } from "./world";

const kMostNodes = 250;
const kSvg = "http://www.w3.org/2000/svg";

export interface Edge {
  a: number;
  b: number;
  force: number; // N
}

// One edge for each pair of moving bodies in contact.
export function edgesOf(world: World): Edge[] {
  const pairs = new Map<string, { a: number; b: number; sum: [number, number, number] }>();
  for (const { a, b, force } of world.contacts) {
    if (world.indexOf[a] === -1 || world.indexOf[b] === -1) continue;
    const key = `${a},${b}`;
    const pair = pairs.get(key) ?? { a, b, sum: [0, 0, 0] };
    pair.sum = [pair.sum[0] + force[0], pair.sum[1] + force[1], pair.sum[2] + force[2]];
    pairs.set(key, pair);
  }
  return [...pairs.values()].map(({ a, b, sum }) => ({ a, b, force: Math.hypot(...sum) }));
}

// Bodies by the least number of contacts from the proxy.
export function layersOf(edges: Edge[], proxy: number): number[][] {
  const neighbours = new Map<number, number[]>();
  for (const { a, b } of edges) {
    neighbours.set(a, [...(neighbours.get(a) ?? []), b]);
    neighbours.set(b, [...(neighbours.get(b) ?? []), a]);
  }
  const seen = new Set([proxy]), layers = [[proxy]];
  for (;;) {
    const next = new Set<number>();
    for (const body of layers[layers.length - 1]!)
      for (const other of neighbours.get(body) ?? []) if (!seen.has(other)) next.add(other);
    if (next.size === 0) return layers;
    for (const body of next) seen.add(body);
    layers.push([...next].sort((a, b) => a - b));
  }
}

export class Graph {
  constructor(private readonly svg: SVGSVGElement, private readonly world: World, hover: (body: number) => void) {
    const bodyAt = (event: Event): number => Number((event.target as Element).getAttribute("data-body") ?? -1);
    svg.addEventListener("pointerover", (event) => hover(bodyAt(event)));
    svg.addEventListener("pointerleave", () => hover(-1));
  }

  // The members, and the bodies that touch one.
  private nearMembers(edges: Edge[]): Set<number> {
    const isMember = (body: number): boolean => (this.world.roles[this.world.indexOf[body]!]! & Role.member) !== 0;
    const near = new Set([this.world.scene.proxy]);
    for (const { a, b } of edges)
      if (isMember(a) || isMember(b)) {
        near.add(a);
        near.add(b);
      }
    return near;
  }

  // Members that contacts do not connect to the proxy: they are not drawn here.
  unlinked = 0;

  draw(highlighted: number): void {
    const edges = edgesOf(this.world), near = this.nearMembers(edges);
    const layers = layersOf(edges, this.world.scene.proxy)
      .map((layer) => layer.filter((body) => near.has(body)))
      .filter((layer) => layer.length > 0);
    const drawn = new Set(layers.flat());
    this.unlinked = this.world.moving.filter((body, i) => (this.world.roles[i]! & Role.member) !== 0 && !drawn.has(body)).length;
    const width = this.svg.clientWidth || 400, height = this.svg.clientHeight || 250;
    const at = new Map<number, [number, number]>();
    let left = kMostNodes;
    layers.forEach((layer, depth) => {
      const shown = layer.slice(0, Math.max(0, left));
      left -= shown.length;
      const y = layers.length === 1 ? height / 2 : 14 + (depth * (height - 28)) / (layers.length - 1);
      shown.forEach((body, k) => at.set(body, [((k + 0.5) * width) / shown.length, y]));
    });
    const parts: Element[] = [];
    const add = (name: string, attributes: Record<string, string | number>): void => {
      const element = document.createElementNS(kSvg, name);
      for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
      parts.push(element);
    };
    for (const { a, b, force } of edges) {
      const from = at.get(a), to = at.get(b);
      if (from === undefined || to === undefined) continue;
      const thickness = Math.min(8, 1 + 2 * Math.log10(1 + 10 * force));
      add("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1], stroke: "#777", "stroke-width": thickness.toFixed(2), "data-edge": `${a},${b}` });
    }
    for (const [body, [x, y]] of at) {
      const i = this.world.indexOf[body]!, look = kLegend[kindOf(this.world.roles[i]!, this.world.isOtherProxy[i]!)];
      const pointed = body === highlighted, ring = pointed ? kPointedAt.edge : look.edge || look.colour;
      add("circle", {
        cx: x.toFixed(1), cy: y.toFixed(1), r: pointed ? 9 : 6, "data-body": body,
        fill: look.see_through ? "#fff" : look.colour, stroke: ring, "stroke-width": ring === look.colour && !look.see_through ? 1 : 2.5,
      });
    }
    this.svg.replaceChildren(...parts);
  }
}
