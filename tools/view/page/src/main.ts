// Connects to the server that this page is from, and shows what it sends.
import { Graph } from "./graph";
import { kSignals, Plots } from "./plots";
import { kLegend, type Layers, Scene3d } from "./scene3d";
import { kWireVersion, parse, Role, type Scene } from "./wire";
import { World } from "./world";

const element = <T extends Element>(id: string): T => document.getElementById(id) as unknown as T;
const say = (id: string, text: string): void => {
  const place = element<HTMLElement>(id);
  if (place.textContent !== text) place.textContent = text;
};

function layersOf(form: HTMLFormElement): Layers {
  const on = (name: string): boolean => (form.elements.namedItem(name) as HTMLInputElement).checked;
  const metresPerNewton = 10 ** Number((form.elements.namedItem("scale") as HTMLInputElement).value);
  say("scale_mm", (1e3 * metresPerNewton).toPrecision(2));
  return { members: on("members"), outside: on("outside"), fixed: on("fixed"), forces: on("forces"), metresPerNewton };
}

class Page {
  private readonly world: World;
  private readonly view: Scene3d;
  private readonly graph: Graph;
  private readonly plots: Plots;
  private readonly form = element<HTMLFormElement>("layers");
  private layers: Layers;
  private hovered = -1;
  private frames = 0;
  private drawn = -1;
  private nextSlow_ms = 0;
  private pace = { wall_ms: NaN, time_s: NaN };

  constructor(private readonly socket: WebSocket, private readonly scene: Scene) {
    this.world = new World(scene);
    this.layers = layersOf(this.form);
    this.view = new Scene3d(element<HTMLCanvasElement>("canvas"), this.world);
    this.graph = new Graph(element<SVGSVGElement>("graph"), this.world, (body) => this.hover(body));
    this.plots = new Plots(element<HTMLElement>("plot"), scene.period_s);
    const name = scene.title || scene.name;
    document.title = `${name} – tactus`;
    say("title", `${name} · ${scene.coupling}/${scene.border} · r=${scene.ratio} · T=${1e3 * scene.period_s} ms`);
    this.addControls();
    requestAnimationFrame((now) => this.draw(now));
  }

  private addControls(): void {
    for (const entry of kLegend) {
      const item = document.createElement("li"), mark = document.createElement("i");
      mark.style.background = entry.colour;
      mark.style.opacity = entry.see_through ? "0.45" : "1";
      if (entry.edge) mark.style.borderColor = "#000";
      item.append(mark, entry.name);
      element("legend").append(item);
    }
    this.form.addEventListener("input", () => {
      this.layers = layersOf(this.form);
      this.drawn = -1;
    });
    const canvas = element<HTMLCanvasElement>("canvas");
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0) this.hover(this.view.pick(event.offsetX, event.offsetY));
    });
    const signal = element<HTMLSelectElement>("signal");
    kSignals.forEach((one, k) => signal.add(new Option(one.name, String(k))));
    signal.addEventListener("change", () => this.plots.choose(Number(signal.value)));
    const seconds = element<HTMLSelectElement>("window");
    seconds.addEventListener("change", () => (this.plots.window_s = Number(seconds.value)));
    const arm = (): void => {
      const on = document.querySelector<HTMLInputElement>("input[name=mode]:checked")!.value === "trigger";
      const kind = element<HTMLSelectElement>("trigger").value as "level" | "step" | "fault";
      this.plots.arm(on ? { kind, level: Number(element<HTMLInputElement>("level").value) } : null);
    };
    for (const input of document.querySelectorAll("input[name=mode], #trigger, #level")) input.addEventListener("change", arm);
    element<HTMLButtonElement>("csv").addEventListener("click", () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([this.plots.csv()], { type: "text/csv" }));
      link.download = `${this.scene.name}.csv`;
      link.click();
      URL.revokeObjectURL(link.href);
    });
    for (const button of document.querySelectorAll<HTMLButtonElement>("button[data-ask]"))
      button.addEventListener("click", () => this.socket.send(JSON.stringify({ ask: button.dataset.ask })));
  }

  private hover(body: number): void {
    if (body === this.hovered) return;
    this.hovered = this.view.highlighted = body;
    this.drawn = -1;
    this.nextSlow_ms = 0;
    if (body < 0) return say("hover", "");
    const role = this.world.roles[this.world.indexOf[body]!]!;
    const words = Object.entries(Role).flatMap(([name, bit]) => ((role & bit) !== 0 ? [name] : []));
    say("hover", `${this.scene.bodies[body]!.label}: ${words.join(", ") || "outside"}`);
  }

  // Takes a message over. The data are the page's from here on, whenever it draws.
  take(buffer: ArrayBuffer): number {
    const message = parse(buffer, this.scene.channels.length);
    this.world.take(message);
    if (message.hasFrame) ++this.frames;
    this.plots.take(message.ticks);
    say("dropped", String(message.dropped));
    say("lost", String(message.lostTicks));
    return message.number;
  }

  private draw(now_ms: number): void {
    const newest = this.plots.newest();
    if (this.drawn !== this.frames) {
      this.drawn = this.frames;
      this.view.update(this.layers);
    }
    if (newest !== null) this.view.setDevice([newest[7]!, newest[8]!, newest[9]!], [newest[4]!, newest[5]!, newest[6]!]);
    this.view.draw();
    if (now_ms >= this.nextSlow_ms) {
      this.nextSlow_ms = now_ms + 100;
      if (newest !== null) this.showFigures(newest, now_ms);
      this.graph.draw(this.hovered);
      this.plots.draw();
      say("caught", this.plots.state());
    }
    requestAnimationFrame((next) => this.draw(next));
  }

  private showFigures(newest: Float32Array, now_ms: number): void {
    const time_s = this.plots.newestTime_s();
    say("time", time_s.toFixed(3));
    if (!(now_ms - this.pace.wall_ms < 1000)) {
      const share = (time_s - this.pace.time_s) / (1e-3 * (now_ms - this.pace.wall_ms));
      if (Number.isFinite(share)) say("share", share.toFixed(2));
      this.pace = { wall_ms: now_ms, time_s };
    }
    say("members", `${newest[14]}/${this.scene.members_cap}`);
    say("contacts", String(newest[16]));
    say("force", Math.hypot(newest[1]!, newest[2]!, newest[3]!).toFixed(2));
    say("fault", newest[22] === 0 ? "none" : `number ${newest[22]}`);
  }
}

function connect(): void {
  const token = location.hash.slice(1);
  if (token === "") return say("state", "no token in the address: open the one that tactus view printed");
  const socket = new WebSocket(`ws://${location.host}/run`, ["tactus", token]);
  socket.binaryType = "arraybuffer";
  let page: Page | null = null, ended = false, waiting = 0;
  // A hidden page takes nothing: what it has not acknowledged is not followed by more.
  const acknowledge = (number: number): void => {
    waiting = number;
    if (document.hidden || waiting === 0) return;
    socket.send(JSON.stringify({ ack: waiting }));
    waiting = 0;
  };
  document.addEventListener("visibilitychange", () => acknowledge(waiting));
  socket.addEventListener("message", ({ data }: MessageEvent<ArrayBuffer | string>) => {
    if (data instanceof ArrayBuffer) {
      if (page !== null) acknowledge(page.take(data));
      return;
    }
    const message = JSON.parse(data) as { kind: string; said?: string };
    if (message.kind === "scene") {
      const scene = message as unknown as Scene;
      if (scene.wire !== kWireVersion) return say("state", "this page is of another version than the viewer: reload it");
      page = new Page(socket, scene);
      say("state", "live: real time cannot be paused");
    } else if (message.kind === "ended") {
      ended = true;
      say("state", "the run is over");
    } else {
      say("answer", message.said ?? "");
    }
  });
  socket.addEventListener("close", () => say("state", ended ? "the run is over" : "not connected: a wrong address, four pages already, or the viewer has ended"));
}

connect();
