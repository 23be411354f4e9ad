// What a scene cannot have: looked for in the text, where the compiler leaves no trace or no place of it, and in the
// compiled model, where defaults have been applied.
import {Mistake} from "./xml.mjs";

const kRefusedElements = [
  // kind, what holds for an element with its parent's name, what it is, what to do
  ["actuators", (e, up) => up === "actuator", "an actuator", "the hand moves what is moved: leave it out, or give a [[joint]] a motor in the scene"],
  ["tendons", (e, up) => up === "tendon", "a tendon", "model the rope by a [[joint]] of kind distance in the scene"],
  ["joint-equality", (e, up) => up === "equality" && e.name !== "connect" && e.name !== "weld", "an equality of joints", "let one of the joints be free, or hold it by a weld"],
  ["mimic", (e, up) => e.name === "mimic" && up === "joint", "a joint that mimics another", "let it be free, or make it fixed"],
  ["flex", (e) => ["flex", "flexcomp", "deformable"].includes(e.name), "a flexible body", "bodies here are rigid: build it from rigid ones"],
  ["composite", (e) => e.name === "composite", "a composite", "write its bodies out"],
  ["plugins", (e, up) => e.name === "extension" || (e.name === "plugin" && up !== "extension"), "a plugin", "leave it out"],
  ["sdf", (e) => e.attributes.type === "sdf" && e.name === "geom", "a shape by its distance function", "give it as a mesh"],
  ["pairs", (e, up) => e.name === "pair" && up === "contact", "a pair of shapes with a contact of its own", "give the friction to the shapes themselves"],
];
const kLeftOut = [
  ["sensors", (e, up) => up === "sensor"],
  ["sites", (e) => e.name === "site"],
  ["cameras", (e) => e.name === "camera"],
  ["lights", (e) => e.name === "light"],
  ["skins", (e) => e.name === "skin"],
  ["materials and textures", (e) => ["material", "texture"].includes(e.name)],
  ["visual shapes", (e) => e.name === "visual" && e.depth > 1],
  ["elements of other programs", (e) => ["gazebo", "transmission", "ros2_control"].includes(e.name)],
  ["custom data", (e, up) => up === "custom"],
];

function shown(element) {
  const name = element.attributes.name ?? element.attributes.joint ?? element.attributes.plugin;
  return `<${element.name}${name === undefined ? "" : ` ${JSON.stringify(name)}`}>`;
}

export function judge_elements(files, found, left_out) {
  const counts = new Map();
  for (const {elements} of files.texts)
    for (const element of elements) {
      const up = element.parent < 0 ? "" : elements[element.parent].name;
      for (const [kind, holds, what, cure] of kRefusedElements)
        if (holds(element, up)) found(kind, element, `${shown(element)} is ${what}`, cure);
      for (const [what, holds] of kLeftOut) if (holds(element, up)) counts.set(what, (counts.get(what) ?? 0) + 1);
    }
  for (const [what, count] of counts) left_out.push(`${what}: ${count}`);
}

// These are left out of the text, so that what else is wrong is found in the same go. Sensors may refer to them.
export function breaks_the_compiler(element) {
  return ["flexcomp", "deformable", "composite", "extension", "plugin", "sensor", "skin"].includes(element.name) ||
    (element.name === "geom" && element.attributes.type === "sdf");
}

const quoted = (thing, what, number) => thing.name === "" ? `${what} ${number}` : `${what} ${JSON.stringify(thing.name)}`;

function judge_joints(model, found, left_out) {
  model.joints.forEach((joint, id) => {
    const name = quoted(joint, "joint", id);
    const has = [
      ["springs", joint.stiffness, "stiffness", "a spring"],
      ["damping", joint.damping, "damping", "damping"],
      ["armature", joint.armature, "armature", "a rotor's inertia"],
      ["friction-loss", joint.friction_loss, "frictionloss", "friction of its own"]];
    for (const [kind, value, attribute, what] of has)
      if (value !== 0) found(kind, joint, `${name} has ${what} (${attribute} ${value})`, `joints here have none: set it to 0`);
    if (joint.type === "ball" && joint.limited && model.limits)
      found("limits", joint, `${name} is a ball with a limit`, "hinges and sliders have limits: make it one, or take the limit away");
  });
  model.bodies.forEach((body, id) => {
    if (body.joints > 1)
      found("several-joints", body, `${quoted(body, "body", id)} has ${body.joints} joints to one other body`,
        "one joint: put bodies in between, of a mass of their own");
    if (body.gravity_compensation !== 0)
      found("gravity-compensation", body, `${quoted(body, "body", id)} has gravcomp`, "set it to 0");
  });
  if (model.joints.some((joint) => joint.force_limited)) left_out.push("limits of joints' efforts");
}

// Do bodies of a and b count as joined, so that they need not collide?
function joined(model, a, b) {
  const weld = (body) => model.bodies[body].weld, up = (body) => weld(model.bodies[weld(body)].parent);
  if (weld(a) === weld(b)) return true;
  if ((weld(a) !== 0 && up(a) === weld(b)) || (weld(b) !== 0 && up(b) === weld(a))) return true;
  return model.equalities.some((e) => e.active && e.body_a >= 0 &&
    ((weld(e.body_a) === weld(a) && weld(e.body_b) === weld(b)) || (weld(e.body_a) === weld(b) && weld(e.body_b) === weld(a))));
}

// Pairs of shapes whose masks keep them apart. Each group: shapes with the same masks, one of each body.
function* pairs_apart(groups) {
  for (let i = 0; i < groups.length; ++i)
    for (let k = 0; k <= i; ++k) {
      const [a, b] = [groups[i][0], groups[k][0]];
      if ((a.contype & b.conaffinity) !== 0 || (b.contype & a.conaffinity) !== 0) continue;
      for (let m = 0; m < groups[i].length; ++m)
        for (let n = 0; n < (k === i ? m : groups[k].length); ++n) yield [groups[i][m], groups[k][n]];
    }
}

function judge_masks(model, found) {
  const moves = (body) => model.bodies[body].weld !== 0;
  const kinds = new Map();  // of masks: of each body that has them one shape
  for (const geom of model.geoms) {
    if (geom.contype === 0 && geom.conaffinity === 0) continue;
    const mask = `${geom.contype} ${geom.conaffinity}`;
    if (!kinds.has(mask)) kinds.set(mask, new Map());
    kinds.get(mask).set(model.bodies[geom.body].weld, geom);
  }
  // Few kinds do not collide, and few bodies are joined: counting ends at `most`, so that no model takes long.
  const groups = Array.from(kinds.values(), (bodies) => Array.from(bodies.values()));
  const most = 1000;
  let count = 0, first = null;
  for (const [a, b] of pairs_apart(groups)) {
    if (!(moves(a.body) || moves(b.body)) || joined(model, a.body, b.body)) continue;
    first ??= [a, b];
    if (++count === most) break;
  }
  const name = (geom) => quoted(model.bodies[geom.body], "body", geom.body);
  const others = count < 2 ? "" : `, and of ${count < most ? count - 1 : `${most - 1} or more`} other pairs of bodies`;
  if (count > 0)
    found("masks", first[0], `contype and conaffinity keep shapes of ${name(first[1])} and ${name(first[0])} apart${others}`,
      "here all bodies collide that no joint holds: give them the masks 1 and 1");
  for (const [a, b] of model.excluded)
    if (!joined(model, a, b))
      found("masks", model.bodies[a], `<exclude> keeps ${quoted(model.bodies[a], "body", a)} and ${quoted(model.bodies[b], "body", b)} apart, which no joint holds`,
        "here all bodies collide that no joint holds: take it away");
}

// A number that is not finite has no place in the answer. Throws a Mistake with the first element that has one.
export function judge_finite(model) {
  const is_finite = (value) => Array.isArray(value) ? value.every(is_finite) : typeof value !== "number" || Number.isFinite(value);
  for (const [kind, list] of [["body", model.bodies], ["geom", model.geoms], ["joint", model.joints],
                              ["equality", model.equalities], ["mesh", model.meshes], ["height field", model.fields]])
    list.forEach((element, id) => {
      const key = Object.keys(element).find((name) => !is_finite(element[name]));
      if (key !== undefined)
        throw new Mistake(`${element.file ?? model.bodies[0].file}:${element.line ?? 0}: ${quoted(element, kind, id)}: its ${key.replace("_", " ")} ` +
          "is not finite; accepted: finite numbers");
    });
  if (!is_finite(model.gravity)) throw new Mistake(`${model.bodies[0].file}: gravity is not finite; accepted: finite numbers`);
}

export function judge_model(description, model, found, left_out) {
  const whole = {file: description.bodies[0].file, line: 0};
  judge_joints(description, found, left_out);
  judge_masks(description, found);
  const fluid = description.geoms.findIndex((geom) => geom.fluid);
  if (description.fluid || fluid >= 0)
    found("fluids", fluid >= 0 ? description.geoms[fluid] : whole, "a fluid: density, viscosity or fluidshape",
      "set them to 0; the scene's [drag] is of another form");
  if (!description.contacts) found("masks", whole, "contacts are switched off by a flag of <option>", "switch them on");
  const inactive = description.equalities.filter((e) => !e.active).length;
  if (inactive > 0) left_out.push(`equality constraints that are not active: ${inactive}`);
  if (description.keyframes > 1) left_out.push(`keyframes after the first, which is the start: ${description.keyframes - 1}`);
  left_out.push("the solver's settings: contacts and joints are as stiff as the scene's [simulation] says");
}
