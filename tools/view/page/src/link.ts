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

export function tokenOf(hash: string): string {
  return hash.slice(1).split("&")[0] ?? "";
}

export function linkOf(hash: string): Link {
  const words = new URLSearchParams(hash.slice(1).split("&").slice(1).join("&"));
  const number = (name: string): number | undefined => {
    const word = words.get(name);
    return word === null || word === "" || !Number.isFinite(Number(word)) ? undefined : Number(word);
  };
  const vector = (name: string): Vector | undefined => {
    const list = (words.get(name) ?? "").split(",").map(Number);
    return list.length === 3 && list.every(Number.isFinite) ? (list as Vector) : undefined;
  };
  const hide = words.get("hide");
  const link: Link = { at: number("at"), pace: number("pace"), signal: number("signal"), window: number("window"), eye: vector("eye"), look: vector("look"), scale: number("scale"), draw: number("draw") };
  return hide === null ? link : { ...link, hide: hide.split(",") };
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
