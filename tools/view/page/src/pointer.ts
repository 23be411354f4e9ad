// A hand by mouse or gamepad: a drag moves the simulated hand in the picture's plane, the wheel in depth, with shift it
// turns. What is sent is how far the hand is to be from where it was taken; the device follows as a hand would.
import { LedHand, type Pose } from "./led_hand";
import type { Scene3d } from "./scene3d";

type Vector = [number, number, number];
type Send = (message: object) => void;

const kEvery_ms = 1000 / 60;
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
  private nextSend_ms = 0;
  private lastPad_ms = NaN;
  private hand: LedHand | null = null; // since it was last taken

  constructor(private readonly canvas: HTMLCanvasElement, private readonly view: Scene3d, private readonly send: Send, private readonly moves: (event_ms: number) => void) {
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
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
    const { right, up, metresPerPixel } = this.view.plane();
    const [dx, dy] = [event.clientX - this.at[0], this.at[1] - event.clientY];
    this.at = [event.clientX, event.clientY];
    if (event.shiftKey) this.turned = add(add(this.turned, up, kTurn_rad_per_px * dx), right, -kTurn_rad_per_px * dy);
    else this.moved = add(add(this.moved, right, metresPerPixel * dx), up, metresPerPixel * dy);
    this.nextSend_ms = Math.min(this.nextSend_ms, performance.now() + 4);
    this.moves(event.timeStamp);
  }

  private wheel(event: WheelEvent): void {
    if (!this.taken) return;
    event.preventDefault();
    const { forward, distance } = this.view.plane();
    this.moved = add(this.moved, forward, -event.deltaY * kDepth_per_wheel * distance);
  }

  private pad(now_ms: number): void {
    const pad = navigator.getGamepads?.().find((one) => one !== null && one.connected);
    const passed_s = Math.min(0.1, 1e-3 * (now_ms - this.lastPad_ms));
    this.lastPad_ms = now_ms;
    if (!pad || !(passed_s > 0)) return;
    const { right, up, forward } = this.view.plane();
    const stick = (at: number): number => (Math.abs(pad.axes[at] ?? 0) > kStickRests ? kStick_m_per_s * passed_s * pad.axes[at]! : 0);
    this.moved = add(add(add(this.moved, right, stick(0)), up, -stick(1)), forward, -stick(3));
  }

  // Once a picture; `at`: the tool, null: it is not known yet.
  draw(now_ms: number, time_s: number, at: Pose | null): void {
    if (!this.taken) return;
    this.pad(now_ms);
    if (this.hand === null && at !== null) this.hand = new LedHand(at);
    this.hand?.advance(time_s, this.moved, this.turned);
    if (now_ms < this.nextSend_ms) return;
    this.nextSend_ms = now_ms + kEvery_ms;
    const short = (value: number): number => Number(value.toFixed(6));
    this.send({ hand: [...this.moved, ...this.turned].map(short) });
  }

  get hasPath(): boolean {
    return this.hand?.hasPath === true;
  }
  motionFile(): string {
    return this.hand!.motionFile();
  }
}
