// Puts a model's files into the compiler's memory: those that it names, and none outside of its folder.
import {readFileSync, realpathSync, statSync} from "node:fs";
import {basename, dirname, join, normalize, sep} from "node:path";
import {Mistake, read_elements} from "./xml.mjs";

const kMaxFileBytes = 64 << 20, kMaxBytes = 256 << 20, kMaxFiles = 2000, kMaxIncludes = 16;
export const kFolder = "/model";

export class ModelFiles {
  // `fs`: Emscripten's. `found(kind, element, what, cure)` takes what is refused.
  constructor(fs, path, found) {
    this.fs = fs;
    this.found = found;
    this.root = realpathSync(dirname(path));
    this.name = basename(path);
    this.sizes = new Map();
    this.bytes = 0;
    this.texts = [];  // {path, text, elements}, the model's own first
    fs.mkdirTree(kFolder);
    fs.chdir(kFolder);
    this.read_text(this.name, {file: this.name, line: 0, name: "model"}, 0);
    this.urdf = this.texts[0].elements[0]?.name === "robot";
    this.settings = {};
    for (const element of this.all()) if (element.name === "compiler") Object.assign(this.settings, element.attributes);
    for (const element of this.all()) this.read_named_by(element);
  }

  all() { return this.texts.flatMap((text) => text.elements); }

  // The file's bytes, or null where it may not be read: that has then been said.
  read(path, element) {
    const shown = `<${element.name}> names ${JSON.stringify(path)}`;
    const cure = `put the file into the model's folder, or below it`;
    const relative = normalize(path);
    if (relative.startsWith("..") || relative.startsWith(sep) || path.includes("\0")) {
      this.found("files", element, `${shown}, which is outside of the model's folder`, cure);
      return null;
    }
    let real;
    try {
      real = realpathSync(join(this.root, relative));
      if (!real.startsWith(this.root + sep)) {
        this.found("files", element, `${shown}, a link that leads outside of the model's folder`, cure);
        return null;
      }
      const status = statSync(real);
      if (!status.isFile()) throw new Error("no file");
      if (status.size > kMaxFileBytes || this.bytes + status.size > kMaxBytes || this.sizes.size >= kMaxFiles) {
        this.found("files", element, `${shown}, of ${status.size} bytes`,
          `files of at most ${kMaxFileBytes >> 20} MB, ${kMaxFiles} files and ${kMaxBytes >> 20} MB in all`);
        return null;
      }
      const bytes = readFileSync(real);
      if (!this.sizes.has(relative)) this.bytes += bytes.length;
      this.sizes.set(relative, bytes.length);
      return bytes;
    } catch {
      this.found("files", element, `${shown}, which cannot be read`, cure);
      return null;
    }
  }

  read_text(path, element, depth) {
    if (this.texts.some((text) => text.path === normalize(path))) return;
    if (depth > kMaxIncludes) throw new Mistake(`${element.file}:${element.line}: files included deeper than ${kMaxIncludes}`);
    const bytes = this.read(path, element);
    if (bytes === null) return;
    const text = bytes.toString("utf8");
    const elements = read_elements(text, path);
    this.texts.push({path: normalize(path), text, elements});
    for (const child of elements)
      if ((child.name === "include" || child.name === "model") && child.attributes.file !== undefined && child.parent >= 0)
        this.read_text(child.attributes.file, child, depth + 1);
  }

  read_named_by(element) {
    if (["include", "model", "robot", "mujoco", "compiler"].includes(element.name)) return;
    for (const [key, value] of Object.entries(element.attributes)) {
      if (this.urdf ? key !== "filename" || element.name !== "mesh" : !/^file/.test(key) || value === "") continue;
      if (this.urdf) this.keep_urdf_mesh(value, element);
      else this.keep_asset(value, element);
    }
  }

  keep_asset(value, element) {
    const stripped = this.settings.strippath === "true" ? basename(value) : value;
    const own = element.name === "texture" ? this.settings.texturedir : this.settings.meshdir;
    const path = join(own ?? this.settings.assetdir ?? "", stripped);
    if (stripped.startsWith("/")) return void this.read(stripped, element);  // says why not
    const bytes = this.read(path, element);
    if (bytes !== null) this.write(path, bytes);
  }

  // MuJoCo looks for a URDF's meshes by their last name, unless told otherwise.
  keep_urdf_mesh(value, element) {
    const path = value.replace(/^file:\/\//, "").replace(/^package:\/\//, "");
    const below = value.startsWith("package://") ? path.replace(/^[^/]*\//, "") : path;
    const tried = [path, below, join(this.settings.meshdir ?? "", basename(path))];
    const there = tried.find((name) => this.is_there(name)) ?? path;
    const bytes = this.read(there, element);
    if (bytes === null) return;
    this.write(path, bytes);
    this.write(join(this.settings.meshdir ?? "", basename(path)), bytes);
  }

  is_there(path) {
    if (normalize(path).startsWith("..") || path.startsWith("/")) return false;
    try { return statSync(join(this.root, path)).isFile(); } catch { return false; }
  }

  write(path, bytes) {
    if (normalize(path).startsWith("..") || path.startsWith("/")) return;
    const whole = join(kFolder, path);
    this.fs.mkdirTree(dirname(whole));
    this.fs.writeFile(whole, bytes);
  }

  // Writes the texts without the elements for which `leave_out` holds; returns the model's own.
  write_texts(leave_out) {
    let own = "";
    for (const {path, text, elements} of this.texts) {
      let kept = "", at = 0;
      for (const element of elements) {
        if (element.begin < at || !leave_out(element)) continue;
        kept += text.slice(at, element.begin) + text.slice(element.begin, element.end).replace(/[^\n]/g, "");  // lines stay
        at = element.end;
      }
      kept += text.slice(at);
      if (own === "" && path === this.name) own = kept;
      this.write(path, kept);
    }
    return own;
  }
}
