// One world as the server sends it: a socket, its bodies, its picture, its ticks.
import { Scene3d } from "./scene3d";
import { kWireVersion, parse, type Scene } from "./wire";
import { World } from "./world";

export interface Said {
  kind: string;
  said?: string;
  ask?: string;
  ok?: boolean;
  ended?: boolean; // of a run's state
}

export interface Listener {
  began(stream: Stream): void;
  ticks(stream: Stream, values: Float32Array, restarts: boolean): void;
  said(message: Said): void;
  closed(ended: boolean): void;
}

export class Stream {
  scene!: Scene;
  world!: World;
  view!: Scene3d;
  frames = 0;
  bytes = 0;
  work_ms = 0; // of taking messages over
  dropped = 0;
  lostTicks = 0;
  tickAge_us = -1; // of the newest tick, when its message was sent; below 0: not measured
  private readonly socket: WebSocket;
  private waiting = 0; // the message to acknowledge
  private ended = false;

  constructor(path: string, token: string, private readonly canvas: HTMLCanvasElement, private readonly listener: Listener) {
    this.socket = new WebSocket(`ws://${location.host}/${path}`, ["tactus", token]);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("message", ({ data }: MessageEvent<ArrayBuffer | string>) => {
      if (data instanceof ArrayBuffer) this.take(data);
      else this.takeText(JSON.parse(data) as Said);
    });
    this.socket.addEventListener("close", () => listener.closed(this.ended));
    document.addEventListener("visibilitychange", () => this.acknowledge());
  }

  send(message: object): void {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  private takeText(message: Said): void {
    this.ended ||= message.kind === "ended" || message.ended === true;
    if (message.kind !== "scene") return this.listener.said(message);
    const scene = message as unknown as Scene;
    if (scene.wire !== kWireVersion) return this.listener.said({ kind: "version" });
    this.scene = scene;
    this.world = new World(scene);
    this.view = new Scene3d(this.canvas, this.world);
    this.listener.began(this);
  }

  // The data are the page's from here on, whenever it draws.
  private take(buffer: ArrayBuffer): void {
    if (this.scene === undefined) return;
    const began_ms = performance.now();
    const message = parse(buffer, this.scene.channels.length);
    this.world.take(message);
    if (message.hasFrame) ++this.frames;
    this.dropped = message.dropped;
    this.lostTicks = message.lostTicks;
    this.tickAge_us = message.tickAge_us;
    this.listener.ticks(this, message.ticks, message.restarts);
    this.bytes += buffer.byteLength;
    this.work_ms += performance.now() - began_ms;
    this.waiting = message.number;
    this.acknowledge();
  }

  // A hidden page takes nothing: what it has not acknowledged is not followed by more.
  private acknowledge(): void {
    if (document.hidden || this.waiting === 0) return;
    this.send({ ack: this.waiting });
    this.waiting = 0;
  }
}
