// The address's fragment: the token, and behind it the view that it brings back.
//   #TOKEN&at=2.5&pace=0.1&signal=1&window=5&eye=0.3,-0.5,0.4&look=0,0,0.1&scale=-2&hide=outside,fixed

export type Vector = [number, number, number];

export interface Link {
  at?: number; // s
  pace?: number;
  signal?: number;
  window?: number; // s
  eye?: Vector; // m: where the camera is, and what it looks at
  look?: Vector;
  scale?: number;
  hide?: string[];
  draw?: number; // 0: nothing is drawn, to measure what is taken
}

// What each word may be; others are left out.
export interface Accepted {
  signals: number; // 0 to this, without it
  windows: number[]; // s
  layers: readonly string[];
}
// m: a camera farther away sees nothing of the scenes that are possible.
const kFarthest_m = 1e4;

export function tokenOf(hash: string): string {
  return hash.slice(1).split("&")[0] ?? "";
}

// `wrong`: a line for each word that is left out.
export function linkOf(hash: string, accepted: Accepted): { link: Link; wrong: string[] } {
  const words = new URLSearchParams(hash.slice(1).split("&").slice(1).join("&"));
  const wrong: string[] = [];
  const refuse = (name: string, what: string): undefined => {
    wrong.push(`link: ${name}=${words.get(name)} is left out; accepted: ${what}`);
    return undefined;
  };
  const number = (name: string, what: string, good: (value: number) => boolean): number | undefined => {
    const word = words.get(name);
    if (word === null) return undefined;
    return word !== "" && Number.isFinite(Number(word)) && good(Number(word)) ? Number(word) : refuse(name, what);
  };
  const vector = (name: string): Vector | undefined => {
    if (!words.has(name)) return undefined;
    const list = words.get(name)!.split(",").map((word) => (word === "" ? NaN : Number(word)));
    return list.length === 3 && list.every((value) => Math.abs(value) <= kFarthest_m) ? (list as Vector) : refuse(name, "x,y,z in m");
  };
  const { signals, windows, layers } = accepted;
  const hide = words.get("hide")?.split(",");
  const link: Link = {
    at: number("at", "seconds, from 0", (value) => value >= 0),
    pace: number("pace", "0.01 to 100, or 0 for as fast as it goes", (value) => value === 0 || (value >= 0.01 && value <= 100)),
    signal: number("signal", `0 to ${signals - 1}`, (value) => Number.isInteger(value) && value >= 0 && value < signals),
    window: number("window", `${windows.join(", ")} s`, (value) => windows.includes(value)),
    eye: vector("eye"),
    look: vector("look"),
    scale: number("scale", "-4 to 0", (value) => value >= -4 && value <= 0),
    draw: number("draw", "0 or 1", (value) => value === 0 || value === 1),
    hide: hide === undefined ? undefined : hide.every((name) => name === "none" || layers.includes(name)) ? hide : refuse("hide", `none, ${layers.join(", ")}`),
  };
  for (const name of new Set(words.keys())) if (!(name in link)) refuse(name, Object.keys(link).join(", "));
  return { link, wrong };
}

export function hashOf(token: string, link: Link): string {
  const short = (value: number): string => String(Number(value.toFixed(4)));
  const parts = Object.entries(link).flatMap(([name, value]) => {
    if (value === undefined) return [];
    if (!Array.isArray(value)) return [`${name}=${short(value as number)}`];
    return value.length === 0 ? [] : [`${name}=${value.map((one) => (typeof one === "number" ? short(one) : one)).join(",")}`];
  });
  return `#${[token, ...parts].join("&")}`;
}
