// Where the simulated hand's target is, as the page knows it: the device's filter (hal/operated_hand.h) run again, for
// the file of the motion.
import { Quaternion, Vector3 } from "three";

const kFollows_rad_per_s = 30, kMaxSpeed_m_per_s = 0.5, kMaxTurn_rad_per_s = 3.0;
const kStep_s = 1e-3, kMostSteps = 1000;
const kRowEvery_s = 0.02;
const kMaxRows = 100_000;

export interface Pose {
  position: [number, number, number]; // m, world
  rotation: [number, number, number, number]; // x y z w, world_from_tool
}

function turnOf(vector: Vector3): Quaternion {
  const angle = vector.length();
  return angle > 0 ? new Quaternion().setFromAxisAngle(vector.clone().divideScalar(angle), angle) : new Quaternion();
}

function vectorOf(turn: Quaternion): Vector3 {
  const sign = turn.w < 0 ? -1 : 1, axis = new Vector3(turn.x, turn.y, turn.z).multiplyScalar(sign), size = axis.length();
  return size > 0 ? axis.multiplyScalar((2 * Math.atan2(size, sign * turn.w)) / size) : axis;
}

function follow(speed: Vector3, left: Vector3, most: number): void {
  const w = kFollows_rad_per_s;
  speed.multiplyScalar(1 - 2 * w * kStep_s).addScaledVector(left, w * w * kStep_s);
  if (speed.length() > most) speed.setLength(most);
}

export class OperatedHand {
  private readonly origin: { position: Vector3; rotation: Quaternion };
  private readonly position: Vector3;
  private readonly rotation: Quaternion;
  private readonly speed = new Vector3();
  private readonly turning = new Vector3();
  private last_s = NaN;
  private rows: string[] = [];
  private lastRow_s = -1;

  constructor(at: Pose) {
    this.origin = { position: new Vector3(...at.position), rotation: new Quaternion(...at.rotation).normalize() };
    this.position = this.origin.position.clone();
    this.rotation = this.origin.rotation.clone();
  }

  // Up to this simulated time, with the wish that then holds: so far from where it was taken [m; rotation vector, rad].
  advance(time_s: number, moved: readonly [number, number, number], turned: readonly [number, number, number]): void {
    if (!(time_s > (Number.isNaN(this.last_s) ? -1 : this.last_s))) return;
    const steps = Number.isNaN(this.last_s) ? 0 : Math.min(kMostSteps, Math.round((time_s - this.last_s) / kStep_s));
    this.last_s = time_s;
    const wish = this.origin.position.clone().add(new Vector3(...moved));
    const heading = turnOf(new Vector3(...turned)).multiply(this.origin.rotation);
    for (let i = 0; i < steps; ++i) {
      follow(this.speed, wish.clone().sub(this.position), kMaxSpeed_m_per_s);
      follow(this.turning, vectorOf(heading.clone().multiply(this.rotation.clone().conjugate())), kMaxTurn_rad_per_s);
      this.position.addScaledVector(this.speed, kStep_s);
      this.rotation.premultiply(turnOf(this.turning.clone().multiplyScalar(kStep_s))).normalize();
    }
    this.keep(time_s);
  }

  private keep(time_s: number): void {
    if (time_s - this.lastRow_s < kRowEvery_s || this.rows.length >= kMaxRows) return;
    this.lastRow_s = time_s;
    const { x, y, z } = this.position, q = this.rotation;
    this.rows.push([time_s.toFixed(3), ...[x, y, z].map((one) => one.toFixed(6)), ...[q.w, q.x, q.y, q.z].map((one) => one.toFixed(7))].join(","));
  }

  get hasPath(): boolean {
    return this.rows.length > 1;
  }
  // What was done, as the file of a scene's [hand]: file = "hand.csv".
  motionFile(): string {
    return ["time_s,position_x_m,position_y_m,position_z_m,rotation_w,rotation_x,rotation_y,rotation_z", ...this.rows].join("\n") + "\n";
  }
}
