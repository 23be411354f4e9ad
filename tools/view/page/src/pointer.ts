// A hand by mouse or gamepad: a drag moves the simulated hand in the picture's plane, the wheel in depth, with shift it
// turns. What is sent is how far the hand is to be from where it was taken; the device follows as a hand would. It is
// sent when the pointer says so, not with the next picture: a browser gathers `pointermove` until then, but not
// `pointerrawupdate`, where it has that.
import { OperatedHand, type Pose } from "./operated_hand";
import type { Scene3d } from "./scene3d";

type Vector = [number, number, number];
type Send = (message: object) => void;

// A mouse may move a thousand times a second; the server takes 250 messages of a page, of which 60 say what it has taken.
const kAtMostEvery_ms = 8;
const kAtLeastEvery_ms = 50; // while pictures are drawn: 0.2 s of silence would hold the hand
const kTurn_rad_per_px = 0.008;
const kDepth_per_wheel = 0.0002; // of the camera's distance, a unit of the wheel
const kStick_m_per_s = 0.15;
const kStickRests = 0.15;

const add = (a: Vector, b: readonly number[], s = 1): Vector => [a[0] + s * b[0]!, a[1] + s * b[1]!, a[2] + s * b[2]!];

export class Pointer {
  taken = false;
  private moved: Vector = [0, 0, 0];
  private turned: Vector = [0, 0, 0];
  private pointer = -1; // that drags
  private at: [number, number] = [0, 0]; // where it is [px]
  private told_ms = -Infinity; // a change
  private sent_ms = -Infinity; // a change, or the same again
  private waits: ReturnType<typeof setTimeout> | undefined; // for kAtMostEvery_ms to be over
  private lastPad_ms = NaN;
  private hand: OperatedHand | null = null; // since it was last taken

  constructor(private readonly canvas: HTMLCanvasElement, private readonly view: Scene3d, private readonly send: Send, private readonly moves: (event_ms: number) => void) {
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    // Both where there are both: what the first has said of a motion, the second says again, without a difference.
    for (const motion of ["pointerrawupdate", "pointermove"] as const) canvas.addEventListener(motion, (event) => this.move(event as PointerEvent));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (this.pointer = -1));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  ask(): void {
    this.send({ ask: this.taken ? "rest" : "take" });
  }
  // The server's answer to it.
  answered(ask: string, ok: boolean): void {
    if (!ok) return;
    this.taken = ask === "take";
    this.view.orbit = !this.taken;
    this.moved = [0, 0, 0];
    this.turned = [0, 0, 0];
    if (this.taken) this.hand = null;
  }

  private down(event: PointerEvent): void {
    if (!this.taken || event.button !== 0) return;
    this.pointer = event.pointerId;
    this.at = [event.clientX, event.clientY];
    this.canvas.setPointerCapture(event.pointerId);
  }

  private move(event: PointerEvent): void {
    if (event.pointerId !== this.pointer) return;
    const [dx, dy] = [event.clientX - this.at[0], this.at[1] - event.clientY];
    if (dx === 0 && dy === 0) return;
    this.at = [event.clientX, event.clientY];
    const { right, up, metresPerPixel } = this.view.plane();
    if (event.shiftKey) this.turned = add(add(this.turned, up, kTurn_rad_per_px * dx), right, -kTurn_rad_per_px * dy);
    else this.moved = add(add(this.moved, right, metresPerPixel * dx), up, metresPerPixel * dy);
    this.moves(event.timeStamp);
    this.tell();
  }

  private wheel(event: WheelEvent): void {
    if (!this.taken) return;
    event.preventDefault();
    const { forward, distance } = this.view.plane();
    this.moved = add(this.moved, forward, -event.deltaY * kDepth_per_wheel * distance);
    this.tell();
  }

  // That it has changed: now, or as soon as kAtMostEvery_ms lets it.
  private tell(): void {
    const left_ms = this.told_ms + kAtMostEvery_ms - performance.now();
    if (left_ms > 0) this.waits ??= setTimeout(() => this.tellNow(), left_ms);
    else this.tellNow();
  }
  private tellNow(): void {
    clearTimeout(this.waits);
    this.waits = undefined;
    this.told_ms = performance.now();
    this.say();
  }
  private say(): void {
    if (!this.taken) return;
    this.sent_ms = performance.now();
    const short = (value: number): number => Number(value.toFixed(6));
    this.send({ hand: [...this.moved, ...this.turned].map(short) });
  }

  private pad(now_ms: number): void {
    const pad = navigator.getGamepads?.().find((one) => one !== null && one.connected);
    const passed_s = Math.min(0.1, 1e-3 * (now_ms - this.lastPad_ms));
    this.lastPad_ms = now_ms;
    if (!pad || !(passed_s > 0)) return;
    const { right, up, forward } = this.view.plane();
    const stick = (at: number): number => (Math.abs(pad.axes[at] ?? 0) > kStickRests ? kStick_m_per_s * passed_s * pad.axes[at]! : 0);
    const before = this.moved;
    this.moved = add(add(add(this.moved, right, stick(0)), up, -stick(1)), forward, -stick(3));
    if (this.moved.some((value, axis) => value !== before[axis])) this.tell();
  }

  // Once a picture; `at`: the tool, null: it is not known yet.
  draw(now_ms: number, time_s: number, at: Pose | null): void {
    if (!this.taken) return;
    this.pad(now_ms);
    if (this.hand === null && at !== null) this.hand = new OperatedHand(at);
    this.hand?.advance(time_s, this.moved, this.turned);
    if (performance.now() - this.sent_ms >= kAtLeastEvery_ms) this.say();
  }

  get hasPath(): boolean {
    return this.hand?.hasPath === true;
  }
  motionFile(): string {
    return this.hand!.motionFile();
  }
}
