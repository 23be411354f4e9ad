// node motion.mjs FOLDER FILE SECONDS: MuJoCo's own motion, by the package in FOLDER: every 10 ms the centres of mass of all
// bodies, in numbers one after the other.
import {readFileSync} from "node:fs";
const [folder, file, seconds] = process.argv.slice(2);
const {default: load} = await import(`${folder}/mujoco.js`);
const mujoco = await load({print: () => {}, printErr: () => {}});
const model = mujoco.mj_compile(mujoco.parseXMLString(readFileSync(file, "utf8")));
const data = new mujoco.MjData(model);
if (model.nkey > 0) mujoco.mj_resetDataKeyframe(model, data, 0);
mujoco.mj_forward(model, data);
const steps = Math.round(0.01 / model.opt.timestep), rows = [];
for (let frame = 0; frame <= Math.round(seconds * 100); ++frame) {
  rows.push(Array.from(data.xipos).join(" "));
  for (let k = 0; k < steps; ++k) mujoco.mj_step(model, data);
  mujoco.mj_forward(model, data);
}
process.stdout.write(rows.join("\n") + "\n");
