// node compile.mjs FILE: compiles an MJCF or URDF model with MuJoCo, and prints one JSON object: the compiled model at its
// start, what a scene cannot have of it, and what is left out. Everything is in the world frame and SI.
//
// It reads no file outside of FILE's folder; the caller limits its time and memory.
import load from "./mujoco.js";
import {ModelFiles} from "./files.mjs";
import {Mistake} from "./xml.mjs";
import {judge_elements, judge_finite, judge_model, breaks_the_compiler} from "./judge.mjs";
import {describe} from "./describe.mjs";

const kMaxBodies = 3000;

function one_line(text) { return text.replace(/\s+/g, " ").replace(/^(MuJoCo Error: |Loading error: |Error: |XML Error: )+/, "").trim(); }

async function run(path) {
  const result = {refused: [], left_out: []};
  const found = (kind, element, what, cure) =>
    result.refused.push({kind, file: element.file ?? "", line: element.line ?? 0, what, cure});
  let files;
  try {
    const mujoco = await load({print: () => {}, printErr: () => {}});
    files = new ModelFiles(mujoco.FS, path, found);
    const bodies = files.all().filter((element) => element.name === "body" || element.name === "link").length;
    if (bodies > kMaxBodies)
      throw new Mistake(`${files.name}: ${bodies} bodies; accepted: at most ${kMaxBodies}, what the compiler has memory for`);
    judge_elements(files, found, result.left_out);
    const own = files.write_texts(breaks_the_compiler);
    const spec = mujoco.parseXMLString(own);
    const model = mujoco.mj_compile(spec);
    const data = new mujoco.MjData(model);
    if (model.nkey > 0) mujoco.mj_resetDataKeyframe(model, data, 0);
    mujoco.mj_forward(model, data);
    const all = {mujoco, spec, model, data, files};
    const described = describe(all);
    judge_finite(described);
    result.model = described;
    judge_model(result.model, model, found, result.left_out);
  } catch (error) {
    if (error instanceof Mistake) result.mistake = error.message;
    else result.error = one_line(String(error?.message ?? error));
  }
  return result;
}

process.stdout.write(JSON.stringify(await run(process.argv[2])));
