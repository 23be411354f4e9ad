// The newest ticks of a run, in a ring: every tick that came, nothing thinned out.

export const kKept = 65536; // ticks; a power of two
export const kChannels = 24;
const kWrap = 1 << 24; // of the tick's number on the wire

export class Ticks {
  private readonly rows = new Float32Array(kKept * kChannels);
  private readonly numbers = new Float64Array(kKept);
  private wraps = 0;
  count = 0; // rows since the start

  constructor(readonly period_s: number) {}

  // The ticks that follow are of another time.
  restart(): void {
    this.count = 0;
    this.wraps = 0;
  }

  // Calls `each` for every row, after it was added.
  take(values: Float32Array, each: (row: Float32Array) => void): void {
    for (let at = 0; at < values.length; at += kChannels) {
      const row = values.subarray(at, at + kChannels), slot = this.count % kKept;
      const number = row[0]! + this.wraps * kWrap;
      const before = this.count > 0 ? this.numbers[(this.count - 1) % kKept]! : -1;
      if (number < before) ++this.wraps;
      this.rows.set(row, slot * kChannels);
      this.numbers[slot] = row[0]! + this.wraps * kWrap;
      each(row);
      ++this.count;
    }
  }

  get oldest(): number {
    return Math.max(0, this.count - kKept);
  }
  row(index: number): Float32Array {
    const at = (index % kKept) * kChannels;
    return this.rows.subarray(at, at + kChannels);
  }
  time_s(index: number): number {
    return (this.numbers[index % kKept]! + 1) * this.period_s;
  }
  // The row whose tick ends at this time; null: it has not come, or is forgotten.
  at(time_s: number): Float32Array | null {
    if (this.count === 0) return null;
    const back = Math.round((this.newestTime_s() - time_s) / this.period_s);
    const index = this.count - 1 - back;
    if (back < 0 || index < this.oldest || Math.abs(this.time_s(index) - time_s) > 0.5 * this.period_s) return null;
    return this.row(index);
  }
  newest(): Float32Array | null {
    return this.count === 0 ? null : this.row(this.count - 1);
  }
  newestTime_s(): number {
    return this.count === 0 ? NaN : this.time_s(this.count - 1);
  }
}
