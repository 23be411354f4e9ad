// The plots: every tick is kept for kKept ticks. Rolling, or held by a trigger with a quarter of the window before it.
import uPlot from "uplot";

const kKept = 65536; // ticks; a power of two
const kChannels = 24;
const kWrap = 1 << 24; // of the tick's number on the wire

interface Signal {
  name: string;
  unit: string;
  lines: { label: string; of: (row: Float32Array) => number }[];
}
const channel = (at: number) => (row: Float32Array): number => row[at]!;
const norm = (at: number) => (row: Float32Array): number => Math.hypot(row[at]!, row[at + 1]!, row[at + 2]!);

// The first line of a signal is the one that a trigger looks at.
export const kSignals: readonly Signal[] = [
  { name: "force", unit: "N", lines: [{ label: "size", of: norm(1) }, { label: "x", of: channel(1) }, { label: "y", of: channel(2) }, { label: "z", of: channel(3) }] },
  { name: "energy at the ports", unit: "J", lines: [{ label: "device", of: channel(10) }, { label: "damped", of: channel(11) }, { label: "border", of: channel(12) }, { label: "border's tank", of: channel(13) }] },
  { name: "counts", unit: "", lines: [{ label: "members", of: channel(14) }, { label: "border points", of: channel(15) }, { label: "contacts", of: channel(16) }, { label: "sub-steps", of: channel(17) }] },
  { name: "deepest overlap", unit: "mm", lines: [{ label: "overlap", of: (row) => 1e3 * row[18]! }] },
  { name: "times of a tick", unit: "us", lines: [{ label: "compute", of: channel(21) }, { label: "wake", of: channel(19) }, { label: "device", of: channel(20) }] },
];
const kColours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
const kDashes = [[], [8, 4], [2, 3], [8, 3, 2, 3]];

export interface Trigger {
  kind: "level" | "step" | "fault";
  level: number;
}

export class Plots {
  private readonly rows = new Float32Array(kKept * kChannels);
  private readonly ticks = new Float64Array(kKept); // numbers
  private count = 0; // rows since the start
  private wraps = 0;
  private chart: uPlot | null = null;
  private caughtAt = -1; // row
  private last = NaN; // the watched line's value
  private lastFault = 0;
  signal = kSignals[0]!;
  window_s = 10;
  trigger: Trigger | null = null;

  constructor(private readonly place: HTMLElement, private readonly period_s: number) {
    this.choose(0);
    new ResizeObserver(() => this.chart?.setSize(this.size())).observe(place);
  }

  choose(index: number): void {
    this.signal = kSignals[index]!;
    this.arm(this.trigger);
    this.chart?.destroy();
    this.chart = new uPlot(
      {
        ...this.size(),
        scales: { x: { time: false } },
        axes: [{ label: "simulated time [s]" }, { label: this.signal.unit === "" ? this.signal.name : `${this.signal.name} [${this.signal.unit}]`, size: 60 }],
        series: [{ label: "t [s]" }, ...this.signal.lines.map((line, k) => ({ label: line.label, stroke: kColours[k]!, dash: kDashes[k]!, width: 1.5 }))],
      },
      [[], ...this.signal.lines.map(() => [])] as unknown as uPlot.AlignedData,
      this.place,
    );
  }

  arm(trigger: Trigger | null): void {
    this.trigger = trigger;
    this.caughtAt = -1;
    this.last = NaN;
  }

  private size(): { width: number; height: number } {
    return { width: Math.max(200, this.place.clientWidth), height: 240 };
  }

  take(values: Float32Array): void {
    for (let at = 0; at < values.length; at += kChannels) {
      const row = values.subarray(at, at + kChannels), slot = this.count % kKept;
      const number = row[0]! + this.wraps * kWrap;
      const before = this.count > 0 ? this.ticks[(this.count - 1) % kKept]! : -1;
      if (number < before) ++this.wraps;
      this.rows.set(row, slot * kChannels);
      this.ticks[slot] = row[0]! + this.wraps * kWrap;
      this.look(row);
      ++this.count;
    }
  }

  private look(row: Float32Array): void {
    const value = this.signal.lines[0]!.of(row), fault = row[22]!;
    const trigger = this.trigger;
    if (trigger !== null && this.caughtAt < 0) {
      const fires =
        trigger.kind === "fault" ? fault !== 0 && this.lastFault === 0
        : trigger.kind === "step" ? Math.abs(value - this.last) > trigger.level
        : value > trigger.level && !(this.last > trigger.level);
      if (fires) this.caughtAt = this.count;
    }
    this.last = value;
    this.lastFault = fault;
  }

  // The rows to show: [from, to), and the one that fired; -1: none.
  private shown(): [number, number, number] {
    const length = Math.min(kKept, Math.round(this.window_s / this.period_s));
    const oldest = Math.max(0, this.count - kKept);
    if (this.caughtAt < 0) return [Math.max(oldest, this.count - length), this.count, -1];
    const from = Math.max(oldest, this.caughtAt - Math.round(length / 4));
    return [from, Math.min(this.count, from + length), this.caughtAt];
  }

  private timeOf(row: number): number {
    return (this.ticks[row % kKept]! + 1) * this.period_s;
  }

  data(): number[][] {
    const [from, to] = this.shown();
    const columns: number[][] = [[], ...this.signal.lines.map(() => [])];
    for (let row = from; row < to; ++row) {
      const values = this.rows.subarray((row % kKept) * kChannels, (row % kKept) * kChannels + kChannels);
      columns[0]!.push(this.timeOf(row));
      this.signal.lines.forEach((line, k) => columns[k + 1]!.push(line.of(values)));
    }
    return columns;
  }

  draw(): void {
    this.chart?.setData(this.data() as unknown as uPlot.AlignedData);
  }

  // What the trigger is doing, as text.
  state(): string {
    if (this.trigger === null) return "";
    const [, to, at] = this.shown();
    if (at < 0) return "waiting";
    return `caught at ${this.timeOf(at).toFixed(3)} s, ${to - at} ticks since`;
  }

  newest(): Float32Array | null {
    if (this.count === 0) return null;
    const at = ((this.count - 1) % kKept) * kChannels;
    return this.rows.subarray(at, at + kChannels);
  }
  newestTime_s(): number {
    return this.count === 0 ? NaN : this.timeOf(this.count - 1);
  }

  csv(): string {
    const columns = this.data();
    const unit = this.signal.unit === "" ? "" : `_${this.signal.unit}`;
    const names = ["time_s", ...this.signal.lines.map((line) => line.label.replaceAll(/\W+/g, "_") + unit)];
    return [names.join(","), ...columns[0]!.map((_, row) => columns.map((column) => column[row]).join(","))].join("\n") + "\n";
  }
}
