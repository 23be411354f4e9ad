// The plots: rolling, or held by a trigger with a quarter of the window before it. A second run's first line is drawn
// over the first one's.
import uPlot from "uplot";
import { kKept, Ticks } from "./ticks";

interface Line {
  label: string;
  of: (row: Float32Array, period_s: number) => number;
}
interface Signal {
  name: string;
  unit: string;
  lines: Line[];
}
const channel = (at: number) => (row: Float32Array): number => row[at]!;
const norm = (at: number) => (row: Float32Array): number => Math.hypot(row[at]!, row[at + 1]!, row[at + 2]!);
// The device and the loop, without the wake-up: from the sample to the force that was computed from it.
// NaN: not measured, as in virtual time.
export const forceAge_us = (row: Float32Array): number => row[20]! + row[21]! || NaN;
const stage_us = (at: number) => (row: Float32Array): number => (Number.isNaN(forceAge_us(row)) ? NaN : row[at]!);
const whole_us = (row: Float32Array): number => row[19]! + forceAge_us(row);
const deadline_us: Line = { label: "deadline", of: (_, period_s) => 1e6 * period_s };
export const isOverrun = (row: Float32Array, period_s: number): boolean => whole_us(row) > 1e6 * period_s;

// The first line of a signal is the one that a trigger looks at.
export const kSignals: readonly Signal[] = [
  { name: "force", unit: "N", lines: [{ label: "size", of: norm(1) }, { label: "x", of: channel(1) }, { label: "y", of: channel(2) }, { label: "z", of: channel(3) }] },
  { name: "energy at the ports", unit: "J", lines: [{ label: "device", of: channel(10) }, { label: "damped", of: channel(11) }, { label: "border", of: channel(12) }, { label: "border's tank", of: channel(13) }] },
  { name: "counts", unit: "", lines: [{ label: "members", of: channel(14) }, { label: "border points", of: channel(15) }, { label: "contacts", of: channel(16) }, { label: "sub-steps", of: channel(17) }] },
  { name: "deepest overlap", unit: "mm", lines: [{ label: "overlap", of: (row) => 1e3 * row[18]! }] },
  { name: "times of a tick", unit: "µs", lines: [{ label: "compute", of: stage_us(21) }, { label: "wake", of: stage_us(19) }, { label: "device", of: stage_us(20) }, deadline_us] },
  { name: "whole tick", unit: "µs", lines: [{ label: "wake to written", of: whole_us }, deadline_us] },
  { name: "force age", unit: "µs", lines: [{ label: "when written", of: forceAge_us }] },
];
const kColours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
const kDashes = [[], [8, 4], [2, 3], [8, 3, 2, 3]];

export interface Trigger {
  kind: "level" | "step" | "fault" | "overrun";
  level: number;
}

export class Plots {
  private chart: uPlot | null = null;
  private caughtAt = -1; // row
  private last = NaN; // the watched line's value
  private lastFault = 0;
  private lastOverrun = false;
  signal = kSignals[0]!;
  window_s = 10;
  trigger: Trigger | null = null;
  overruns = 0; // seen by this page

  constructor(private readonly place: HTMLElement, readonly ticks: Ticks, private beside: Ticks | null = null) {
    this.choose(0);
    new ResizeObserver(() => this.chart?.setSize(this.size())).observe(place);
  }

  setBeside(beside: Ticks): void {
    this.beside = beside;
    this.choose(kSignals.indexOf(this.signal));
  }

  choose(index: number): void {
    this.signal = kSignals[index] ?? kSignals[0]!;
    this.arm(this.trigger);
    this.chart?.destroy();
    const named = (label: string): string => (this.signal.unit === "" ? label : `${label} [${this.signal.unit}]`);
    const over = this.beside === null ? [] : [{ label: named(`${this.signal.lines[0]!.label}, beside`), stroke: "#000000", dash: [3, 3], width: 1.5 }];
    this.chart = new uPlot(
      {
        ...this.size(),
        scales: { x: { time: false } },
        axes: [{ label: "simulated time [s]" }, { label: named(this.signal.name), size: 60 }],
        series: [{ label: "t [s]" }, ...this.signal.lines.map((line, k) => ({ label: named(line.label), stroke: kColours[k]!, dash: kDashes[k]!, width: 1.5 })), ...over],
      },
      [[], ...this.labels().map(() => [])] as unknown as uPlot.AlignedData,
      this.place,
    );
  }

  private labels(): string[] {
    const own = this.signal.lines.map((line) => line.label);
    return this.beside === null ? own : [...own, `${own[0]!} beside`];
  }

  arm(trigger: Trigger | null): void {
    this.trigger = trigger;
    this.caughtAt = -1;
    this.last = NaN;
  }

  private size(): { width: number; height: number } {
    return { width: Math.max(200, this.place.clientWidth), height: 240 };
  }

  restart(): void {
    this.ticks.restart();
    this.arm(this.trigger);
    this.lastFault = NaN; // of another time: a fault latched there is not reported
    this.lastOverrun = true;
  }

  take(values: Float32Array): void {
    this.ticks.take(values, (row) => this.look(row));
  }

  private look(row: Float32Array): void {
    const value = this.signal.lines[0]!.of(row, this.ticks.period_s), fault = row[22]!, overrun = isOverrun(row, this.ticks.period_s);
    if (overrun) ++this.overruns;
    const trigger = this.trigger;
    if (trigger !== null && this.caughtAt < 0) {
      const fires =
        trigger.kind === "fault" ? fault !== 0 && this.lastFault === 0
        : trigger.kind === "overrun" ? overrun && !this.lastOverrun
        : trigger.kind === "step" ? Math.abs(value - this.last) > trigger.level
        : value > trigger.level && this.last <= trigger.level; // a crossing: one that is above already does not fire
      if (fires) this.caughtAt = this.ticks.count;
    }
    this.last = value;
    this.lastFault = fault;
    this.lastOverrun = overrun;
  }

  // The rows to show: [from, to), and the one that fired; -1: none.
  private shown(): [number, number, number] {
    const { count, oldest, period_s } = this.ticks;
    const length = Math.min(kKept, Math.round(this.window_s / period_s));
    if (this.caughtAt < 0) return [Math.max(oldest, count - length), count, -1];
    const from = Math.max(oldest, this.caughtAt - Math.round(length / 4));
    return [from, Math.min(count, from + length), this.caughtAt];
  }

  data(): (number | null)[][] {
    const [from, to] = this.shown();
    const columns: (number | null)[][] = [[], ...this.labels().map(() => [])];
    const first = this.signal.lines[0]!;
    for (let index = from; index < to; ++index) {
      const row = this.ticks.row(index), time_s = this.ticks.time_s(index);
      columns[0]!.push(time_s);
      this.signal.lines.forEach((line, k) => {
        const value = line.of(row, this.ticks.period_s);
        columns[k + 1]!.push(Number.isNaN(value) ? null : value);
      });
      if (this.beside === null) continue;
      const other = this.beside.at(time_s);
      columns[columns.length - 1]!.push(other === null ? null : first.of(other, this.beside.period_s));
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
    return `caught at ${this.ticks.time_s(at).toFixed(3)} s, ${to - at} ticks since`;
  }

  csv(): string {
    const columns = this.data();
    const unit = this.signal.unit === "" ? "" : `_${this.signal.unit.replace("µ", "u")}`;
    const names = ["time_s", ...this.labels().map((label) => label.replaceAll(/\W+/g, "_") + unit)];
    return [names.join(","), ...columns[0]!.map((_, row) => columns.map((column) => column[row] ?? "").join(","))].join("\n") + "\n";
  }
}
