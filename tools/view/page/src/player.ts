// The controls of time: of a tape, and of a run in virtual time. Real time has none.

export interface Judged {
  level: "good" | "degraded" | "bad";
  verdict: string;
  why: string; // a line for each reason
  of: string;
}

export interface TapeState {
  playing: boolean;
  pace: number; // times real time; 0: as fast as it goes
  begin_s: number;
  end_s: number;
  tapes: { path: string; faults_s: number[]; note: string; verdict?: Judged }[];
}

export type Ask = (ask: string, value?: number) => void;

export class Player {
  private readonly place = document.getElementById("player") as HTMLElement;
  private readonly play = this.find<HTMLButtonElement>("button[data-time=play]");
  private readonly pace = this.find<HTMLSelectElement>("#pace");
  private readonly scrub = this.find<HTMLInputElement>("#scrub");
  private playing = true;
  private wanted_s: number | null = null; // of a drag, sent once a picture
  private dragging = false;

  constructor(private readonly ask: Ask) {
    for (const button of this.place.querySelectorAll<HTMLButtonElement>("button[data-time]"))
      button.addEventListener("click", () => {
        const word = button.dataset.time!;
        ask(word === "play" && this.playing ? "pause" : word);
      });
    this.pace.addEventListener("change", () => ask("pace", Number(this.pace.value)));
    this.scrub.addEventListener("input", () => (this.wanted_s = Number(this.scrub.value)));
    this.scrub.addEventListener("pointerdown", () => (this.dragging = true));
    this.scrub.addEventListener("change", () => (this.dragging = false));
  }

  private find<T extends Element>(selector: string): T {
    return this.place.querySelector(selector) as T;
  }

  showPlaying(playing: boolean): void {
    this.playing = playing;
    this.play.textContent = playing ? "pause" : "play";
  }

  showPace(pace: number): void {
    const known = [...this.pace.options].some((option) => Number(option.value) === pace);
    if (!known) this.pace.add(new Option(`${pace} ×`, String(pace)));
    this.pace.value = String(pace);
  }

  // A run in virtual time: it goes on, and not back.
  showVirtual(): void {
    this.place.hidden = false;
    for (const part of this.place.querySelectorAll<HTMLElement>(".tape")) part.hidden = true;
    this.showPlaying(true);
  }

  showTape(state: TapeState): void {
    this.place.hidden = false;
    for (const part of this.place.querySelectorAll<HTMLElement>(".tape")) part.hidden = false;
    this.showPlaying(state.playing);
    this.showPace(state.pace);
    this.scrub.min = String(state.begin_s);
    this.scrub.max = String(state.end_s);
    const marks = state.tapes.flatMap((tape) => tape.faults_s);
    this.find("#marks").replaceChildren(...marks.map((time_s) => new Option(`fault at ${time_s.toFixed(3)} s`, String(time_s))));
  }

  // Once a picture.
  draw(time_s: number): void {
    if (this.wanted_s !== null) this.ask("seek", this.wanted_s);
    this.wanted_s = null;
    if (!this.dragging && Number.isFinite(time_s)) this.scrub.value = String(time_s);
  }
}
