// The compiled model as plain values: what tools/import/compiled_model.h has.

const kNames = ["plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"];
const kJoints = ["free", "ball", "slide", "hinge"];
const kEqualities = ["connect", "weld", "joint", "tendon", "flex", "flexvert", "flexstrain", "distance"];

const part = (list, index, width) => Array.from(list.slice(index * width, (index + 1) * width));
const add = (a, b) => a.map((value, i) => value + b[i]);
const turned = (matrix, v) => [0, 1, 2].map((row) => matrix[3 * row] * v[0] + matrix[3 * row + 1] * v[1] + matrix[3 * row + 2] * v[2]);

// 0: no, 1: yes, 2: where there is a range. The compiled model's own flags are arrays that this package cannot give.
const is_limited = (flag, range) => (flag?.value ?? flag) === 1 || ((flag?.value ?? flag) !== 0 && range[0] < range[1]);

// Lines: by the name in the text, else MuJoCo's own "line 12", of the model's own file.
class Places {
  constructor({mujoco, spec, files}) {
    this.named = new Map();
    for (const element of files.all())
      if (element.attributes.name !== undefined && !this.named.has(`${element.name} ${element.attributes.name}`))
        this.named.set(`${element.name} ${element.attributes.name}`, element);
    this.own = files.name;
    this.mujoco = mujoco;
    this.spec = spec;
  }
  // Calls f(id, element of the spec) for each of a kind.
  each(kind, f) {
    for (let e = this.mujoco.mjs_firstElement(this.spec, kind); e; e = this.mujoco.mjs_nextElement(this.spec, e))
      f(this.mujoco.mjs_getId(e), e);
  }
  of(tags, name, info) {
    for (const tag of tags) {
      const element = this.named.get(`${tag} ${name}`);
      if (name !== "" && element) return {file: element.file, line: element.line};
    }
    return {file: this.own, line: Number(/line (\d+)/.exec(info ?? "")?.[1] ?? 0)};
  }
}

export function describe(all) {
  const {mujoco: m, model, data} = all;
  const types = m.mjtObj, places = new Places(all);
  // Of the spec: mj_id2name gives other text where there is no name.
  const names = new Map();
  const name_of = (type, id) => {
    if (!names.has(type)) {
      const list = [];
      places.each(type, (number, element) => { list[number] = m.mjs_getName(element); });
      names.set(type, list);
    }
    return names.get(type)[id] ?? "";
  };
  const infos = (type, as) => {
    const out = [];
    places.each(type, (id, element) => { out[id] = as(element); });
    return out;
  };
  const body_specs = infos(types.mjOBJ_BODY, (e) => m.mjs_asBody(e));
  const geom_specs = infos(types.mjOBJ_GEOM, (e) => m.mjs_asGeom(e));
  const equality_specs = infos(types.mjOBJ_EQUALITY, (e) => m.mjs_asEquality(e));
  const joint_specs = infos(types.mjOBJ_JOINT, (e) => m.mjs_asJoint(e));

  const bodies = [];
  for (let id = 0; id < model.nbody; ++id) {
    const name = name_of(types.mjOBJ_BODY, id), spec = body_specs[id];
    const velocity = new m.DoubleBuffer(6);
    m.mj_objectVelocity(model, data, types.mjOBJ_BODY.value, id, velocity, 0);
    const twist = Array.from(velocity.GetView());
    velocity.delete();
    bodies.push({
      name, ...places.of(["body", "link"], name, spec?.info), parent: model.body_parentid[id], weld: model.body_weldid[id],
      mocap: model.body_mocapid[id] >= 0, mass: model.body_mass[id], inertia: part(model.body_inertia, id, 3),
      centre: part(data.xipos, id, 3), axes: part(data.ximat, id, 9), position: part(data.xpos, id, 3), frame: part(data.xmat, id, 9),
      angular_velocity: twist.slice(0, 3), velocity: twist.slice(3), explicit_inertia: spec?.explicitinertial ?? false,
      joints: model.body_jntnum[id], gravity_compensation: model.body_gravcomp[id]});
  }

  const geoms = [];
  for (let id = 0; id < model.ngeom; ++id) {
    const name = name_of(types.mjOBJ_GEOM, id);
    const data_id = model.geom_dataid[id], type = kNames[model.geom_type[id]] ?? "other";
    geoms.push({
      name, ...places.of(["geom", "collision"], name, geom_specs[id]?.info), body: model.geom_bodyid[id], type,
      size: part(model.geom_size, id, 3), position: part(data.geom_xpos, id, 3), axes: part(data.geom_xmat, id, 9),
      contype: model.geom_contype[id], conaffinity: model.geom_conaffinity[id], condim: model.geom_condim[id],
      friction: part(model.geom_friction, id, 3), mesh: type === "mesh" ? data_id : -1,
      field: type === "hfield" ? data_id : -1, fluid: model.geom_fluid[12 * id] !== 0});
  }

  const joints = [];
  for (let id = 0; id < model.njnt; ++id) {
    const name = name_of(types.mjOBJ_JOINT, id), dof = model.jnt_dofadr[id], body = model.jnt_bodyid[id];
    const type = kJoints[model.jnt_type[id]], dofs = {free: 6, ball: 3, slide: 1, hinge: 1}[type];
    const most = (list, width = 1) => Math.max(...Array.from(list.slice(dof * width, (dof + dofs) * width), Math.abs));
    const stiff = [model.jnt_stiffness[id], ...part(model.jnt_stiffnesspoly, id, model.jnt_stiffnesspoly.length / model.njnt)];
    const width = model.dof_dampingpoly.length / model.nv;
    joints.push({
      name, ...places.of(["joint", "freejoint"], name, joint_specs[id]?.info), type, body, parent: model.body_parentid[body],
      anchor: part(data.xanchor, id, 3), axis: part(data.xaxis, id, 3), limited: is_limited(joint_specs[id]?.limited, part(model.jnt_range, id, 2)),
      range: part(model.jnt_range, id, 2), coordinate: data.qpos[model.jnt_qposadr[id]],
      stiffness: Math.max(...stiff.map(Math.abs)), damping: Math.max(most(model.dof_damping), most(model.dof_dampingpoly, width)),
      armature: most(model.dof_armature), friction_loss: most(model.dof_frictionloss),
      force_limited: is_limited(joint_specs[id]?.actfrclimited, part(model.jnt_actfrcrange, id, 2))});
  }

  const equalities = [];
  const sites = types.mjOBJ_SITE.value;
  for (let id = 0; id < model.neq; ++id) {
    const name = name_of(types.mjOBJ_EQUALITY, id), type = kEqualities[model.eq_type[id]] ?? "other";
    const at = places.of([type], name, "");
    if (at.line === 0) {
      const same = all.files.all().filter((e) => e.name === type && !e.attributes.name);
      if (same.length === 1) Object.assign(at, {file: same[0].file, line: same[0].line});
    }
    const equality = {name, ...at, type, active: equality_specs[id]?.active ?? true, body_a: -1, body_b: -1, anchor: [0, 0, 0], error: 0};
    if (type === "connect" || type === "weld") {
      const by_site = model.eq_objtype[id] === sites, a = model.eq_obj1id[id], b = model.eq_obj2id[id];
      const values = part(model.eq_data, id, model.eq_data.length / model.neq);
      equality.body_a = by_site ? model.site_bodyid[a] : a;
      equality.body_b = by_site ? model.site_bodyid[b] : b;
      // A weld's anchor is in the second body's frame, a connect's first one in the first's.
      const held = type === "connect" ? a : b;
      equality.anchor = by_site ? part(data.site_xpos, held, 3)
        : add(part(data.xpos, held, 3), turned(part(data.xmat, held, 9), values.slice(0, 3)));
      for (let row = 0; row < data.ne; ++row)
        if (data.efc_id[row] === id) equality.error = Math.max(equality.error, Math.abs(data.efc_pos[row]));
    }
    equalities.push(equality);
  }

  const meshes = [];
  for (let id = 0; id < model.nmesh; ++id) {
    const name = name_of(types.mjOBJ_MESH, id);
    meshes.push({name, ...places.of(["mesh"], name, ""),
      corners: Array.from(model.mesh_vert.slice(3 * model.mesh_vertadr[id], 3 * (model.mesh_vertadr[id] + model.mesh_vertnum[id]))),
      triangles: Array.from(model.mesh_face.slice(3 * model.mesh_faceadr[id], 3 * (model.mesh_faceadr[id] + model.mesh_facenum[id])))});
  }
  const fields = [];
  for (let id = 0; id < model.nhfield; ++id) {
    const rows = model.hfield_nrow[id], columns = model.hfield_ncol[id], from = model.hfield_adr[id];
    fields.push({name: name_of(types.mjOBJ_HFIELD, id), rows, columns, size: part(model.hfield_size, id, 4),
      heights: Array.from(model.hfield_data.slice(from, from + rows * columns))});
  }

  const excluded = Array.from(model.exclude_signature.slice(0, model.nexclude), (signature) => [signature >>> 16, signature & 0xffff]);
  const off = model.opt.disableflags, bits = m.mjtDisableBit;
  const is_off = (bit) => (off & (bit.value ?? bit)) !== 0;
  return {
    urdf: all.files.urdf, name: all.files.texts[0].elements[0]?.attributes[all.files.urdf ? "name" : "model"] ?? "",
    bodies, geoms, joints, equalities, meshes, fields, excluded,
    gravity: is_off(bits.mjDSBL_GRAVITY) ? [0, 0, 0] : Array.from(model.opt.gravity),
    contacts: !is_off(bits.mjDSBL_CONTACT), parents_filtered: !is_off(bits.mjDSBL_FILTERPARENT),
    limits: !is_off(bits.mjDSBL_LIMIT), equality_rows: !is_off(bits.mjDSBL_EQUALITY),
    fluid: model.opt.density !== 0 || model.opt.viscosity !== 0, keyframes: model.nkey};
}
