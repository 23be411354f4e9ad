// What the server sends; tools/view/wire.h has the layout and its units.

export interface Shape {
  kind: "sphere" | "capsule" | "box" | "cylinder" | "cone" | "plane" | "mesh" | "compound";
  radius?: number;
  half_length?: number;
  half?: [number, number, number];
  points?: number[];
  triangles?: number[];
  parts?: Part[];
}

// A shape of a compound, in the body's frame.
export interface Part {
  shape: Shape;
  position: [number, number, number];
  rotation: [number, number, number, number]; // w x y z
}

export interface Body {
  shape: number;
  fixed: boolean;
  position: [number, number, number];
  rotation: [number, number, number, number]; // w x y z
  label: string;
}

export interface Scene {
  kind: "scene";
  wire: number;
  name: string;
  title: string;
  made_by: string;
  device: string;
  coupling: string;
  border: string;
  ratio: number;
  period_s: number;
  virtual_time: boolean;
  members_cap: number;
  proxy: number;
  other_proxies: number[]; // of the scene's other hands
  reach_m: number; // of the proxy, for the boundary cube; 0: there is none
  channels: { name: string; unit: string }[];
  shapes: Shape[];
  bodies: Body[];
}

export const Role = { proxy: 1, member: 2, border: 4, asleep: 8, unknown: 16 } as const;

export interface Message {
  number: number;
  full: boolean;
  hasFrame: boolean;
  restarts: boolean; // the ticks before are of another time
  tickAge_us: number; // of the newest tick when this was sent; below 0: not measured
  time_s: number;
  dropped: number;
  lostTicks: number;
  component: number;
  leftOut: number;
  resets: number;
  indices: Uint32Array | null; // null: all bodies in their order
  positions: Float32Array; // 3 a body
  rotations: Int16Array; // 4 a body: w x y z times 32,767
  roles: Uint32Array; // role in the highest 8 bits, index below
  ticks: Float32Array; // one value for each channel
  contacts: DataView; // 32 bytes each
  contactCount: number;
}

const kMagic = 0x46434154;
export const kWireVersion = 3;
const kHeaderBytes = 64;

export function parse(buffer: ArrayBuffer, channels: number): Message {
  const head = new DataView(buffer, 0, kHeaderBytes);
  const word = (at: number): number => head.getUint32(at, true);
  if (word(0) !== kMagic || word(4) !== kWireVersion) throw new Error("a message of another version");
  const [bodies, roles, ticks, contacts] = [word(24), word(28), word(32), word(36)] as const;
  const hasFrame = (word(60) & 1) !== 0, full = (word(60) & 4) !== 0;
  let at = kHeaderBytes;
  const take = (bytes: number): number => {
    const from = at;
    at += bytes;
    return from;
  };
  const indices = full || !hasFrame ? null : new Uint32Array(buffer, take(4 * bodies), bodies);
  const message = {
    number: word(8),
    full,
    hasFrame,
    restarts: (word(60) & 2) !== 0,
    tickAge_us: head.getFloat32(12, true),
    time_s: head.getFloat64(16, true),
    dropped: word(40),
    lostTicks: word(44),
    component: word(48),
    leftOut: word(52),
    resets: word(56),
    indices,
    positions: new Float32Array(buffer, take(12 * bodies), 3 * bodies),
    rotations: new Int16Array(buffer, take(8 * bodies), 4 * bodies),
    roles: new Uint32Array(buffer, take(4 * roles), roles),
    ticks: new Float32Array(buffer, take(4 * channels * ticks), channels * ticks),
    contacts: new DataView(buffer, take(32 * contacts), 32 * contacts),
    contactCount: contacts,
  };
  if (at !== buffer.byteLength) throw new Error(`a message of ${buffer.byteLength} bytes that should have ${at}`);
  return message;
}
