// How long it takes from a pointer's event to the first tick in which the tool has moved, and until that tick's force is
// on this page. One value for each move after a rest.
import { type Ticks } from "./ticks";

const kRests_ms = 300; // of the wish, before a move that is measured
const kRestTicks = 100; // whose spread is the tool's own motion at rest
const kLeast_m = 5e-6; // beyond that spread, along one axis
const kTarget = 7; // channels: x y z of the tool

export class Lag {
  private lastMove_ms = -Infinity;
  private began_ms = NaN; // of the event; NaN: nothing is measured
  private from = 0; // the first row that may show it
  private low: number[] = [];
  private high: number[] = [];
  readonly toTick_ms: number[] = [];
  readonly toPage_ms: number[] = [];

  // The wish changes by this event.
  moved(event_ms: number, ticks: Ticks): void {
    const rested = event_ms - this.lastMove_ms > kRests_ms && ticks.count - ticks.oldest > kRestTicks;
    this.lastMove_ms = event_ms;
    if (!rested) return;
    this.began_ms = event_ms;
    this.from = ticks.count;
    const rows = Array.from({ length: kRestTicks }, (_, i) => ticks.row(ticks.count - 1 - i));
    const axes = [0, 1, 2].map((axis) => rows.map((row) => row[kTarget + axis]!));
    this.low = axes.map((values) => Math.min(...values) - kLeast_m);
    this.high = axes.map((values) => Math.max(...values) + kLeast_m);
  }

  // New ticks are there; the newest was this old when it was sent.
  look(ticks: Ticks, tickAge_us: number, now_ms: number): void {
    if (Number.isNaN(this.began_ms) || tickAge_us < 0) return;
    for (; this.from < ticks.count; ++this.from) {
      const row = ticks.row(this.from);
      if (![0, 1, 2].some((axis) => !(row[kTarget + axis]! >= this.low[axis]! && row[kTarget + axis]! <= this.high[axis]!))) continue;
      const back_ms = 1e3 * ticks.period_s * (ticks.count - 1 - this.from);
      const toTick_ms = now_ms - 1e-3 * tickAge_us - back_ms - this.began_ms;
      if (toTick_ms < 0) { // ran before the event: the tool moved by itself
        for (const axis of [0, 1, 2]) {
          this.low[axis] = Math.min(this.low[axis]!, row[kTarget + axis]! - kLeast_m);
          this.high[axis] = Math.max(this.high[axis]!, row[kTarget + axis]! + kLeast_m);
        }
        continue;
      }
      this.toTick_ms.push(toTick_ms);
      this.toPage_ms.push(now_ms - this.began_ms);
      this.began_ms = NaN;
      return;
    }
  }

  // The newest, as text.
  text(): string {
    const at = this.toTick_ms.length - 1;
    return at < 0 ? "" : `pointer to tick ${this.toTick_ms[at]!.toFixed(0)} ms, to this page ${this.toPage_ms[at]!.toFixed(0)} ms`;
  }
}
