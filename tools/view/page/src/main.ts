// Connects to the server that this page is from, and shows what it sends.
import { Quaternion } from "three";
import { Graph } from "./graph";
import { Lag } from "./lag";
import type { Pose } from "./operated_hand";
import { hashOf, type Link, linkOf, tokenOf } from "./link";
import { type Judged, Player, type TapeState } from "./player";
import { forceAge_us, kSignals, Plots } from "./plots";
import { kLegend, kPointedAt, type Layers } from "./scene3d";
import { Pointer } from "./pointer";
import { type Listener, type Said, Stream } from "./stream";
import { Ticks } from "./ticks";
import { Role } from "./wire";

const element = <T extends Element>(id: string): T => document.getElementById(id) as unknown as T;
const say = (id: string, text: string): void => {
  const place = element<HTMLElement>(id);
  if (place.textContent !== text) place.textContent = text;
};
const kLinkEvery_ms = 500; // browsers bear about three changes of the address a second
const kLayers = ["members", "outside", "fixed", "forces", "cube"] as const;

interface RunState extends Judged {
  ended: boolean;
  fault_page?: string; // the address of the fault's tape, served beside
  fault_tape_error: string;
  pace?: number; // in virtual time
}

function layersOf(form: HTMLFormElement): Layers {
  const on = (name: string): boolean => (form.elements.namedItem(name) as HTMLInputElement).checked;
  const metresPerNewton = 10 ** Number((form.elements.namedItem("scale") as HTMLInputElement).value);
  say("scale_mm", (1e3 * metresPerNewton).toPrecision(2));
  return { members: on("members"), outside: on("outside"), fixed: on("fixed"), forces: on("forces"), cube: on("cube"), metresPerNewton };
}

// What a run, or each tape, came to, by the rules of `tactus run`; null: it is not judged yet.
function showVerdict(verdicts: (Judged | null)[]): void {
  say("verdict", verdicts.map((one) => (one === null ? "not judged yet" : `${one.verdict} (${one.of})`)).join(" · "));
  const place = element<HTMLElement>("why");
  place.hidden = verdicts.every((one) => one === null || one.why === "");
  const worst = (["bad", "degraded", "good"] as const).find((level) => verdicts.some((one) => one?.level === level));
  element<HTMLElement>("judged").dataset["level"] = worst ?? "";
  say("why", verdicts.map((one) => one?.why ?? "").join("\n").trimEnd());
}

function download(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

class Page implements Listener {
  private readonly form = element<HTMLFormElement>("layers");
  private readonly player: Player;
  private readonly main: Stream;
  private beside: Stream | null = null;
  private plots: Plots | null = null;
  private graph: Graph | null = null;
  private pointer: Pointer | null = null;
  private readonly lag = new Lag();
  private besideTicks: Ticks | null = null;
  private layers: Layers;
  private readonly link: Link;
  private readonly wrongLink: string[];
  private isTape = false;
  private hovered = -1;
  private drawn = "";
  private nextSlow_ms = 0;
  private nextLink_ms = 0;
  private pace = { wall_ms: NaN, time_s: NaN };
  private statedPace = NaN; // by the run, last
  private pictures = 0;
  private saved = Promise.resolve(); // pictures are saved in the order of their frames, however long coding one takes
  private readonly done = { pictures: 0, update_ms: 0, render_ms: 0 }; // drawn so far: by this script, by WebGL

  constructor(private readonly token: string) {
    this.layers = layersOf(this.form);
    const windows = [...element<HTMLSelectElement>("window").options].map((option) => Number(option.value));
    const { link, wrong } = linkOf(location.hash, { signals: kSignals.length, windows, layers: kLayers });
    this.link = link;
    this.wrongLink = wrong;
    this.player = new Player((ask, value) => this.ask(ask, value));
    this.main = new Stream("run", token, element("canvas"), this);
  }

  private ask(ask: string, value?: number): void {
    this.main.send(value === undefined ? { ask } : { ask, value });
  }

  // --- what the streams say

  began(stream: Stream): void {
    if (stream !== this.main) {
      this.besideTicks = new Ticks(stream.scene.period_s);
      this.plots!.setBeside(this.besideTicks);
      this.main.view.onMove = (): void => stream.view.lookFrom(this.main.view.eye.eye, this.main.view.eye.look);
      stream.view.onMove = (): void => this.main.view.lookFrom(stream.view.eye.eye, stream.view.eye.look);
      this.main.view.onMove();
      return;
    }
    const { scene, world } = stream;
    this.graph = new Graph(element<SVGSVGElement>("graph"), world, (body) => this.hover(body));
    this.plots = new Plots(element<HTMLElement>("plot"), new Ticks(scene.period_s));
    const name = scene.title || scene.name;
    document.title = `${name} – tactus`;
    say("title", `${name} · ${scene.coupling}/${scene.border} · r=${scene.ratio} · T=${1e3 * scene.period_s} ms`);
    this.addControls();
    this.useLink();
    say("state", scene.virtual_time ? "live: virtual time" : "live: real time cannot be paused");
    if (scene.virtual_time) this.player.showVirtual();
    this.pointer = new Pointer(element<HTMLCanvasElement>("canvas"), stream.view, (message) => stream.send(message), (event_ms) => this.lag.moved(event_ms, this.plots!.ticks));
    element<HTMLElement>("hand").hidden = scene.device !== "sim";
    // For the console, and for tests: what the picture has.
    Object.assign(element<HTMLCanvasElement>("canvas"), { drawn: (body: number) => stream.view.drawn(body), look: (body: number) => stream.view.look(body), taken: () => stream.frames });
    requestAnimationFrame((now) => this.draw(now));
  }

  ticks(stream: Stream, values: Float32Array, restarts: boolean): void {
    if (stream !== this.main) {
      if (restarts) this.besideTicks?.restart();
      return this.besideTicks?.take(values, () => undefined);
    }
    if (restarts) {
      this.plots!.restart();
      this.pace = { wall_ms: NaN, time_s: NaN }; // between two places of a tape there is none
      say("share", "–");
    }
    this.plots!.take(values);
    this.lag.look(this.plots!.ticks, stream.tickAge_us, performance.now());
    say("dropped", String(stream.dropped));
    say("lost", String(stream.lostTicks));
  }

  said(message: Said): void {
    if (message.kind === "answer") this.answered(message);
    if (message.kind === "tape") this.takeTape(message as unknown as TapeState);
    else if (message.kind === "state") this.takeState(message as unknown as RunState);
    else if (message.kind === "version") say("state", "this page is of another version than the viewer: reload it");
    else if (message.kind === "ended") this.ended("the run is over");
    else if (message.said !== "") say("answer", message.said ?? "");
  }

  private answered({ ask, ok }: Said): void {
    if (ask === "take" || ask === "rest") this.pointer?.answered(ask, ok === true);
    say("take", this.pointer?.taken === true ? "let the hand rest" : "take the hand");
    if (ok !== true || ask === undefined) return;
    if (ask === "play" || ask === "pause" || ask === "tick" || ask === "cycle") this.player.showPlaying(ask === "play");
  }

  closed(ended: boolean): void {
    this.ended(ended ? "the run is over" : "not connected: a wrong address, four pages already, or the viewer has ended");
  }

  // Nobody answers any more: what would ask is off.
  private ended(why: string): void {
    say("state", why);
    for (const input of document.querySelectorAll<HTMLButtonElement | HTMLInputElement | HTMLSelectElement>("[data-ask], [data-time], #take, #pace, #scrub"))
      input.disabled = true;
  }

  // What the run says of itself.
  private takeState(state: RunState): void {
    // A state may be older than what was chosen here since.
    if (state.pace !== undefined && state.pace !== this.statedPace) this.player.showPace((this.statedPace = state.pace));
    showVerdict([{ ...state, of: state.ended ? "of the whole run" : "so far" }]);
    const link = element<HTMLAnchorElement>("fault_page");
    link.hidden = (state.fault_page ?? "") === "";
    if (!link.hidden) link.href = state.fault_page!;
    if (state.fault_tape_error !== "") say("answer", `the fault's last seconds: ${state.fault_tape_error}`);
  }

  private takeTape(state: TapeState): void {
    this.player.showTape(state);
    showVerdict(state.tapes.map((tape) => tape.verdict ?? null));
    const name = (path: string): string => path.split("/").pop()!;
    say("note", state.tapes.map((tape) => (state.tapes.length > 1 ? `${name(tape.path)}: ${tape.note}` : tape.note)).join(" · "));
    say("state", `tape: ${state.tapes.map((tape) => name(tape.path)).join(" beside ")}`);
    if (this.isTape) return;
    this.isTape = true;
    element<HTMLElement>("asks").hidden = element<HTMLElement>("hand").hidden = true;
    if (this.link.pace !== undefined) this.ask("pace", this.link.pace);
    if (this.link.at !== undefined) this.ask("seek", this.link.at);
    if (state.tapes.length < 2) return;
    const canvas = element<HTMLCanvasElement>("canvas_beside");
    canvas.hidden = false;
    this.beside = new Stream("beside", this.token, canvas, this);
  }

  // --- controls

  private addControls(): void {
    const { otherProxy, ...always } = kLegend;
    const severalHands = this.main.scene.other_proxies.length > 0;
    for (const entry of [...Object.values(always), ...(severalHands ? [otherProxy] : []), { ...kPointedAt, colour: "#fff", see_through: false }]) {
      const item = document.createElement("li"), mark = document.createElement("i");
      mark.style.background = entry.colour;
      mark.style.opacity = entry.see_through ? "0.45" : "1";
      if (entry.edge !== "") mark.style.borderColor = entry.edge;
      item.append(mark, entry.name);
      element("legend").append(item);
    }
    this.form.addEventListener("input", () => {
      this.layers = layersOf(this.form);
      this.drawn = "";
    });
    element<HTMLCanvasElement>("canvas").addEventListener("pointermove", (event) => {
      if (event.buttons === 0) this.hover(this.main.view.pick(event.offsetX, event.offsetY));
    });
    this.addPlotControls();
    element<HTMLButtonElement>("picture").addEventListener("click", () => this.savePicture(`${this.main.scene.name}.png`));
    element<HTMLButtonElement>("copy").addEventListener("click", () => void navigator.clipboard?.writeText(location.href));
    element<HTMLButtonElement>("take").addEventListener("click", () => this.pointer?.ask());
    element<HTMLButtonElement>("save").addEventListener("click", () => {
      if (this.pointer?.hasPath === true) download(new Blob([this.pointer.motionFile()], { type: "text/csv" }), "hand.csv");
      else say("answer", "nothing to save yet: take the hand");
    });
    for (const button of document.querySelectorAll<HTMLButtonElement>("button[data-ask]"))
      button.addEventListener("click", () => this.ask(button.dataset.ask!));
  }

  private addPlotControls(): void {
    const plots = this.plots!;
    const signal = element<HTMLSelectElement>("signal");
    kSignals.forEach((one, k) => signal.add(new Option(one.name, String(k))));
    signal.addEventListener("change", () => plots.choose(Number(signal.value)));
    const seconds = element<HTMLSelectElement>("window");
    seconds.addEventListener("change", () => (plots.window_s = Number(seconds.value)));
    const arm = (): void => {
      const on = document.querySelector<HTMLInputElement>("input[name=mode]:checked")!.value === "trigger";
      const kind = element<HTMLSelectElement>("trigger").value as "level" | "step" | "fault" | "overrun";
      plots.arm(on ? { kind, level: Number(element<HTMLInputElement>("level").value) } : null);
    };
    for (const input of document.querySelectorAll("input[name=mode], #trigger, #level")) input.addEventListener("change", arm);
    element<HTMLButtonElement>("csv").addEventListener("click", () =>
      download(new Blob([plots.csv()], { type: "text/csv" }), `${this.main.scene.name}.csv`));
  }

  private savePicture(name: string): void {
    const coded = new Promise<Blob | null>((done) => element<HTMLCanvasElement>("canvas").toBlob(done));
    this.saved = this.saved.then(async () => {
      const blob = await coded;
      if (blob !== null) download(blob, name);
    });
  }

  private hover(body: number): void {
    if (body === this.hovered) return;
    this.hovered = this.main.view.highlighted = body;
    if (this.beside?.view !== undefined) this.beside.view.highlighted = body;
    this.drawn = "";
    this.nextSlow_ms = 0;
    this.showHovered();
  }

  // The body that is pointed at, and its roles at this moment.
  private showHovered(): void {
    const body = this.hovered, { world, scene } = this.main;
    if (body < 0) return say("hover", "");
    const index = world.indexOf[body]!, role = world.roles[index]!;
    const words = Object.entries(Role).flatMap(([name, bit]) => ((role & bit) !== 0 ? [name] : []));
    if (world.isOtherProxy[index] === true) words.unshift("proxy of another hand");
    say("hover", `${scene.bodies[body]!.label}: ${words.join(", ") || "outside"}`);
  }

  // --- the link

  private useLink(): void {
    const { link } = this, set = (id: string, value: number | undefined): void => {
      const input = element<HTMLInputElement>(id);
      if (value === undefined) return;
      input.value = String(value);
      input.dispatchEvent(new Event("change"));
    };
    set("signal", link.signal);
    set("window", link.window);
    if (link.scale !== undefined) (this.form.elements.namedItem("scale") as HTMLInputElement).value = String(link.scale);
    if (link.hide !== undefined)
      for (const name of kLayers) (this.form.elements.namedItem(name) as HTMLInputElement).checked = !link.hide.includes(name);
    this.layers = layersOf(this.form);
    if (link.eye !== undefined && link.look !== undefined) this.main.view.lookFrom(link.eye, link.look);
    if (this.wrongLink.length > 0) say("answer", this.wrongLink.join(" · "));
  }

  // The address always brings back what is seen now.
  private updateLink(time_s: number): void {
    const { eye, look } = this.main.view.eye;
    const link: Link = {
      at: this.isTape && Number.isFinite(time_s) ? time_s : undefined,
      pace: this.isTape ? Number(element<HTMLSelectElement>("pace").value) : undefined,
      signal: kSignals.indexOf(this.plots!.signal), window: this.plots!.window_s, eye, look,
      scale: Math.log10(this.layers.metresPerNewton),
      hide: kLayers.filter((name) => !this.layers[name]),
    };
    if (link.hide!.length === 0) link.hide = ["none"];
    const hash = hashOf(this.token, link);
    if (hash !== location.hash) history.replaceState(null, "", hash);
  }

  // --- drawing

  private draw(now_ms: number): void {
    requestAnimationFrame((next) => this.draw(next));
    const ticks = this.plots!.ticks, newest = ticks.newest();
    const other = this.besideTicks?.newest() ?? null;
    const frames = `${this.main.frames}/${this.beside?.frames ?? 0}`;
    const fresh = this.drawn !== frames && this.link.draw !== 0;
    const began_ms = performance.now();
    if (fresh) {
      this.drawn = frames;
      this.main.view.update(this.layers);
      this.beside?.view?.update(this.layers);
    }
    if (newest !== null) this.main.view.showDevice(newest);
    if (other !== null) this.beside?.view.showDevice(other);
    this.pointer?.draw(now_ms, ticks.newestTime_s(), newest === null ? null : this.toolAt(newest));
    const updated_ms = performance.now();
    if (this.link.draw === 0) return this.measure();
    this.main.view.draw();
    this.beside?.view?.draw();
    this.player.draw(ticks.newestTime_s());
    if (fresh && element<HTMLInputElement>("numbered").checked)
      this.savePicture(`${this.main.scene.name}_${String(this.pictures++).padStart(6, "0")}.png`);
    if (fresh) this.measure({ update_ms: updated_ms - began_ms, render_ms: performance.now() - updated_ms });
    if (now_ms >= this.nextSlow_ms) {
      this.nextSlow_ms = now_ms + 100;
      if (newest !== null) this.showFigures(newest, now_ms);
      this.showHovered();
      this.graph!.draw(this.hovered);
      say("unlinked", this.graph!.unlinked === 0 ? "" : `members that contacts do not connect to it, not drawn here: ${this.graph!.unlinked}`);
      this.plots!.draw();
      say("caught", this.plots!.state());
    }
    if (now_ms >= this.nextLink_ms) {
      this.nextLink_ms = now_ms + kLinkEvery_ms;
      this.updateLink(ticks.newestTime_s());
    }
  }

  // The device's target, and the proxy's rotation since the scene's start: the tool's, as far as the page knows it.
  private toolAt(newest: Float32Array): Pose {
    const { scene, world } = this.main, at = 4 * world.indexOf[scene.proxy]!;
    const [w, x, y, z] = scene.bodies[scene.proxy]!.rotation;
    const now = world.frames > 0 ? new Quaternion(...world.rotations.subarray(at, at + 4)) : new Quaternion(x, y, z, w);
    const turn = now.multiply(new Quaternion(x, y, z, w).conjugate());
    return { position: [newest[7]!, newest[8]!, newest[9]!], rotation: [turn.x, turn.y, turn.z, turn.w] };
  }

  // What the page has done so far, for who measures it (tools/bench/view_in_browser).
  private measure(drew: { update_ms: number; render_ms: number } | null = null): void {
    const { frames, bytes, dropped, work_ms } = this.main, { done } = this;
    done.pictures += drew === null ? 0 : 1;
    done.update_ms += drew?.update_ms ?? 0;
    done.render_ms += drew?.render_ms ?? 0;
    const { toTick_ms, toPage_ms } = this.lag;
    Object.assign(document.body.dataset, { frames, bytes, dropped, take_ms: work_ms, lags: toTick_ms.length, to_tick_ms: toTick_ms.at(-1) ?? NaN, to_page_ms: toPage_ms.at(-1) ?? NaN, ...done });
    const newest = this.plots!.ticks.newest();
    if (newest !== null) Object.assign(document.body.dataset, { target_x: newest[7], target_y: newest[8], target_z: newest[9] });
  }

  private showFigures(newest: Float32Array, now_ms: number): void {
    const time_s = this.plots!.ticks.newestTime_s();
    say("time", time_s.toFixed(3));
    if (!(now_ms - this.pace.wall_ms < 1000)) {
      const share = (time_s - this.pace.time_s) / (1e-3 * (now_ms - this.pace.wall_ms));
      if (Number.isFinite(share)) say("share", share.toFixed(2));
      this.pace = { wall_ms: now_ms, time_s };
    }
    say("lag", this.lag.text());
    say("members", `${newest[14]}/${this.main.scene.members_cap}`);
    say("contacts", String(newest[16]));
    say("force", Math.hypot(newest[1]!, newest[2]!, newest[3]!).toFixed(2));
    const age_us = forceAge_us(newest), measured = !Number.isNaN(age_us);
    say("age", measured ? `${age_us.toFixed(0)} µs` : "not measured");
    say("overruns", measured || this.plots!.overruns > 0 ? String(this.plots!.overruns) : "not measured");
    say("fault", newest[22] === 0 ? "none" : `number ${newest[22]}`);
  }
}

const token = tokenOf(location.hash);
if (token === "") say("state", "no token in the address: open the one that tactus view printed");
else new Page(token);
