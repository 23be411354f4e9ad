// The state of the run as the page knows it: poses and roles of the bodies, the newest contacts.
import { type Message, type Scene } from "./wire";

export interface Contact {
  a: number;
  b: number;
  point: [number, number, number];
  force: [number, number, number]; // N, on b
}

export class World {
  readonly moving: number[]; // ids of the moving bodies, in the order of the wire
  readonly positions: Float32Array; // by moving body
  readonly rotations: Float32Array; // x y z w
  readonly roles: Uint8Array;
  readonly indexOf: Int32Array; // by id: among the moving bodies; -1
  readonly isOtherProxy: boolean[]; // by moving body
  contacts: Contact[] = [];
  component = 0;
  time_s = 0;
  frames = 0;

  constructor(readonly scene: Scene) {
    this.moving = scene.bodies.flatMap((body, id) => (body.fixed ? [] : [id]));
    this.positions = new Float32Array(3 * this.moving.length);
    this.rotations = new Float32Array(4 * this.moving.length);
    this.roles = new Uint8Array(this.moving.length);
    this.indexOf = new Int32Array(scene.bodies.length).fill(-1);
    this.moving.forEach((id, i) => (this.indexOf[id] = i));
    this.isOtherProxy = this.moving.map((id) => scene.other_proxies.includes(id));
  }

  take(message: Message): void {
    if (!message.hasFrame) return;
    const { indices, positions, rotations } = message;
    const count = positions.length / 3;
    for (let k = 0; k < count; ++k) {
      const i = indices === null ? k : indices[k]!;
      this.positions.set(positions.subarray(3 * k, 3 * k + 3), 3 * i);
      for (let j = 0; j < 4; ++j) this.rotations[4 * i + ((j + 3) % 4)] = rotations[4 * k + j]! / 32767;
    }
    for (const word of message.roles) this.roles[word & 0xffffff] = word >>> 24;
    this.contacts = [];
    for (let k = 0; k < message.contactCount; ++k) {
      const at = 32 * k;
      const real = (offset: number): number => message.contacts.getFloat32(at + offset, true);
      this.contacts.push({
        point: [real(0), real(4), real(8)],
        force: [real(12), real(16), real(20)],
        a: message.contacts.getUint32(at + 24, true),
        b: message.contacts.getUint32(at + 28, true),
      });
    }
    this.component = message.component;
    this.time_s = message.time_s;
    ++this.frames;
  }
}
