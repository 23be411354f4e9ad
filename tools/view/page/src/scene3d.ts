// The world in 3-D: one instanced mesh a shape and layer, contact forces as arrows, the spring from device to proxy.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { Role, type Part, type Shape } from "./wire";
import type { World } from "./world";

// Of the Okabe-Ito palette: colour-blind people tell them apart. Members are solid, others see-through, the border has
// its edges drawn, the proxy of another hand too, in another colour: it is never the colour alone.
interface Look {
  name: string;
  colour: string;
  edge: string; // colour of the edges; "": they are not drawn
  see_through: boolean;
}
export const kLegend = {
  proxy: { name: "proxy", colour: "#d55e00", edge: "", see_through: false },
  member: { name: "member", colour: "#56b4e9", edge: "", see_through: false },
  border: { name: "border: black edges", colour: "#e69f00", edge: "#000000", see_through: false },
  awake: { name: "outside, awake: see-through", colour: "#009e73", edge: "", see_through: true },
  asleep: { name: "outside, asleep: see-through", colour: "#999999", edge: "", see_through: true },
  otherProxy: { name: "proxy of another hand: red edges", colour: "#f0e442", edge: "#d55e00", see_through: false },
  fixed: { name: "fixed", colour: "#d8d2c4", edge: "", see_through: false },
} as const satisfies Record<string, Look>;
export type Kind = keyof typeof kLegend;
// Edges of the body that is pointed at, whatever its kind.
export const kPointedAt = { name: "pointed at: blue edges", edge: "#0000ff" } as const;

// What a moving body is drawn as.
export function kindOf(role: number, otherHand: boolean): Kind {
  if ((role & Role.proxy) !== 0) return "proxy";
  if (otherHand) return "otherProxy";
  if ((role & Role.border) !== 0) return "border";
  if ((role & Role.member) !== 0) return "member";
  return (role & Role.asleep) !== 0 ? "asleep" : "awake";
}

const kColour = Object.fromEntries(Object.entries(kLegend).map(([kind, look]) => [kind, new THREE.Color(look.colour)])) as Record<Kind, THREE.Color>;
const kEdge = Object.fromEntries(Object.entries(kLegend).map(([kind, look]) => [kind, look.edge === "" ? null : new THREE.Color(look.edge)])) as Record<Kind, THREE.Color | null>;
const kPointedEdge = new THREE.Color(kPointedAt.edge);
const kPlaneWidth_m = 4;
const kMaxArrows = 4096;

export interface Layers {
  members: boolean;
  outside: boolean;
  fixed: boolean;
  forces: boolean;
  cube: boolean;
  metresPerNewton: number;
}

const rotationOf = (part: Part): THREE.Quaternion => {
  const [w, x, y, z] = part.rotation;
  return new THREE.Quaternion(x, y, z, w);
};

function geometryOf(shape: Shape): THREE.BufferGeometry {
  switch (shape.kind) {
    case "sphere":
      return new THREE.SphereGeometry(shape.radius!, 20, 14);
    case "capsule":
      return new THREE.CapsuleGeometry(shape.radius!, 2 * shape.half_length!, 6, 16).rotateX(Math.PI / 2);
    case "cylinder":
      return new THREE.CylinderGeometry(shape.radius!, shape.radius!, 2 * shape.half_length!, 32).rotateX(Math.PI / 2);
    case "cone": // its base is a quarter of the height below the centre of mass
      return new THREE.ConeGeometry(shape.radius!, 2 * shape.half_length!, 32).rotateX(Math.PI / 2).translate(0, 0, 0.5 * shape.half_length!);
    case "box":
      return new THREE.BoxGeometry(2 * shape.half![0], 2 * shape.half![1], 2 * shape.half![2]);
    case "plane":
      return new THREE.PlaneGeometry(kPlaneWidth_m, kPlaneWidth_m);
    case "mesh": {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(shape.points!, 3));
      geometry.setIndex(shape.triangles!);
      const flat = geometry.toNonIndexed();
      flat.computeVertexNormals();
      return flat;
    }
    case "compound":
      return mergeGeometries(
        shape.parts!.map((part) => {
          const own = geometryOf(part.shape), flat = own.index === null ? own : own.toNonIndexed();
          flat.deleteAttribute("uv");
          return flat.applyQuaternion(rotationOf(part)).translate(...part.position);
        }),
      );
  }
}

// The smallest box along the world's axes that holds the shape, from the body's centre [m].
function boundsOf(shape: Shape, rotation: THREE.Quaternion): THREE.Box3 {
  const box = new THREE.Box3();
  const hold = (x: number, y: number, z: number): void => void box.expandByPoint(new THREE.Vector3(x, y, z).applyQuaternion(rotation));
  if (shape.kind === "sphere") hold(0, 0, 0);
  if (shape.kind === "box") for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) hold(x * shape.half![0], y * shape.half![1], z * shape.half![2]);
  if (shape.kind === "capsule") for (const z of [-1, 1]) hold(0, 0, z * shape.half_length!);
  for (let i = 0; i < (shape.points?.length ?? 0); i += 3) hold(shape.points![i]!, shape.points![i + 1]!, shape.points![i + 2]!);
  for (const part of shape.parts ?? []) box.union(boundsOf(part.shape, rotation.clone().multiply(rotationOf(part))).translate(new THREE.Vector3(...part.position).applyQuaternion(rotation)));
  if (shape.kind === "cylinder" || shape.kind === "cone") {
    const low = shape.kind === "cone" ? -0.5 * shape.half_length! : -shape.half_length!;
    for (let i = 0; i < 32; ++i)
      for (const top of [false, true]) {
        const radius = top && shape.kind === "cone" ? 0 : shape.radius!, angle = (2 * Math.PI * i) / 32;
        hold(radius * Math.cos(angle), radius * Math.sin(angle), low + (top ? 2 * shape.half_length! : 0));
      }
    return box;
  }
  return box.expandByScalar(shape.radius ?? 0);
}

// Half the side of the smallest cube, along the world's axes, that holds the shape [m].
function halfSide(shape: Shape, rotation: THREE.Quaternion): number {
  const size = boundsOf(shape, rotation).getSize(new THREE.Vector3());
  return 0.5 * Math.max(size.x, size.y, size.z);
}

// Pose and colour of an instance, from body i of the world's arrays.
function place(mesh: THREE.InstancedMesh, slot: number, i: number, positions: Float32Array, rotations: Float32Array, colour: THREE.Color): void {
  const m = mesh.instanceMatrix.array, at = 16 * slot, p = 3 * i, q = 4 * i;
  const x = rotations[q]!, y = rotations[q + 1]!, z = rotations[q + 2]!, w = rotations[q + 3]!;
  m[at] = 1 - 2 * (y * y + z * z);
  m[at + 1] = 2 * (x * y + z * w);
  m[at + 2] = 2 * (x * z - y * w);
  m[at + 4] = 2 * (x * y - z * w);
  m[at + 5] = 1 - 2 * (x * x + z * z);
  m[at + 6] = 2 * (y * z + x * w);
  m[at + 8] = 2 * (x * z + y * w);
  m[at + 9] = 2 * (y * z - x * w);
  m[at + 10] = 1 - 2 * (x * x + y * y);
  m[at + 12] = positions[p]!;
  m[at + 13] = positions[p + 1]!;
  m[at + 14] = positions[p + 2]!;
  m[at + 15] = 1;
  colour.toArray(mesh.instanceColor!.array, 3 * slot);
}

// The moving bodies of one shape, in three meshes: solid ones, which are members and proxies, edges, and the others.
interface Group {
  bodies: number[]; // among the moving ones
  solid: THREE.InstancedMesh;
  edges: THREE.InstancedMesh;
  outside: THREE.InstancedMesh;
  solidBodies: number[];
  edgeBodies: number[];
  outsideBodies: number[];
}

// Without a graphics card WebGL is drawn by the processor: smooth edges would take a quarter of the picture's time.
function drawsInSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  const renderer = names ? String(gl!.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /llvmpipe|softpipe|swiftshader|basic render/i.test(renderer);
}

export class Scene3d {
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(45, 1, 0.005, 100);
  private readonly controls: OrbitControls;
  private readonly groups: Group[] = [];
  private readonly fixed = new THREE.Group();
  private readonly arrows: THREE.LineSegments;
  private readonly heads: THREE.InstancedMesh;
  private readonly target: THREE.Mesh;
  private readonly spring: THREE.Line;
  private readonly cube = new THREE.LineSegments(new THREE.EdgesGeometry(new THREE.BoxGeometry(2, 2, 2)), new THREE.LineBasicMaterial({ color: "#0072b2" }));
  private changed = true;
  highlighted = -1; // id of a body, or -1
  onMove: (() => void) | null = null; // a person has moved the camera
  private following = false;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly world: World) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !drawsInSoftware(), preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene.background = new THREE.Color("#f4f6f8");
    const light = new THREE.DirectionalLight("#ffffff", 2);
    light.position.set(1, -2, 3);
    this.scene.add(light, new THREE.HemisphereLight("#ffffff", "#b0a890", 1.6), this.fixed);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => {
      this.changed = true;
      if (!this.following) this.onMove?.();
    });
    world.scene.shapes.forEach((shape, index) => this.addGroup(geometryOf(shape), shape, index));
    const lines = new THREE.BufferGeometry();
    lines.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6 * kMaxArrows), 3));
    this.arrows = new THREE.LineSegments(lines, new THREE.LineBasicMaterial({ color: "#111111" }));
    this.arrows.frustumCulled = false;
    const cone = new THREE.ConeGeometry(0.0015, 0.005, 8).translate(0, -0.0025, 0);
    this.heads = new THREE.InstancedMesh(cone, new THREE.MeshBasicMaterial({ color: "#111111" }), kMaxArrows);
    this.heads.frustumCulled = false;
    this.target = new THREE.Mesh(
      new THREE.SphereGeometry(0.006, 12, 8),
      new THREE.MeshBasicMaterial({ color: "#cc79a7", wireframe: true }),
    );
    this.spring = new THREE.Line(
      new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(new Float32Array(6), 3)),
      new THREE.LineBasicMaterial({ color: "#cc79a7" }),
    );
    this.spring.frustumCulled = false;
    this.scene.add(this.arrows, this.heads, this.target, this.spring, this.cube);
    this.lookAtProxy();
  }

  private addGroup(geometry: THREE.BufferGeometry, shape: Shape, index: number): void {
    const { scene, indexOf } = this.world;
    const fixed = scene.bodies.filter((body) => body.fixed && body.shape === index);
    if (fixed.length > 0) {
      // Walls are seen through: what they hold is what one wants to see. The ground is not.
      const ground = shape.kind === "plane" || shape.kind === "mesh";
      const look = ground ? {} : { transparent: true, opacity: 0.25, depthWrite: false };
      const material = new THREE.MeshStandardMaterial({ color: kColour.fixed, roughness: 1, side: THREE.DoubleSide, flatShading: shape.kind === "mesh", ...look });
      const mesh = new THREE.InstancedMesh(geometry, material, fixed.length);
      const matrix = new THREE.Matrix4(), one = new THREE.Vector3(1, 1, 1);
      fixed.forEach((body, k) => {
        const [w, x, y, z] = body.rotation;
        mesh.setMatrixAt(k, matrix.compose(new THREE.Vector3(...body.position), new THREE.Quaternion(x, y, z, w), one));
      });
      this.fixed.add(mesh);
    }
    const bodies = scene.bodies.flatMap((body, id) => (!body.fixed && body.shape === index ? [indexOf[id]!] : []));
    if (bodies.length === 0) return;
    const instanced = (material: THREE.Material): THREE.InstancedMesh => {
      const mesh = new THREE.InstancedMesh(geometry, material, bodies.length);
      mesh.frustumCulled = false;
      mesh.setColorAt(0, kColour.proxy); // makes the colours' buffer
      this.scene.add(mesh);
      return mesh;
    };
    this.groups.push({
      bodies,
      solid: instanced(new THREE.MeshStandardMaterial({ roughness: 0.7 })),
      edges: instanced(new THREE.MeshBasicMaterial({ wireframe: true })),
      outside: instanced(new THREE.MeshStandardMaterial({ roughness: 1, transparent: true, opacity: 0.45, depthWrite: false })),
      solidBodies: [],
      edgeBodies: [],
      outsideBodies: [],
    });
  }

  private lookAtProxy(): void {
    const [x, y, z] = this.world.scene.bodies[this.world.scene.proxy]!.position;
    const around = this.world.scene.bodies.filter((body) => !body.fixed).map((body) => Math.hypot(body.position[0] - x, body.position[1] - y, body.position[2] - z));
    around.sort((a, b) => a - b);
    const radius = Math.min(2, Math.max(0.15, around[Math.min(around.length - 1, 100)] ?? 0.3));
    this.controls.target.set(x, y, z - 0.4 * radius);
    this.camera.position.set(x + 1.1 * radius, y - 2 * radius, z + 1.3 * radius);
    this.controls.update();
  }

  // Where the camera is, and what it looks at [m].
  get eye(): { eye: [number, number, number]; look: [number, number, number] } {
    return { eye: this.camera.position.toArray(), look: this.controls.target.toArray() };
  }
  lookFrom(eye: [number, number, number], look: [number, number, number]): void {
    this.following = true;
    this.camera.position.set(...eye);
    this.controls.target.set(...look);
    this.controls.update();
    this.following = false;
    this.changed = true;
  }

  // False: the mouse is the hand's, not the camera's.
  set orbit(on: boolean) {
    this.controls.enableRotate = this.controls.enableZoom = on;
  }
  // The picture's plane in the world, at the device's target [m].
  plane(): { right: [number, number, number]; up: [number, number, number]; forward: [number, number, number]; metresPerPixel: number; distance: number } {
    const axis = (column: number): THREE.Vector3 => new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, column);
    const forward = axis(2).negate();
    const distance = Math.max(0.01, this.target.position.clone().sub(this.camera.position).dot(forward));
    const height = 2 * distance * Math.tan((0.5 * Math.PI * this.camera.fov) / 180);
    return { right: axis(0).toArray(), up: axis(1).toArray(), forward: forward.toArray(), metresPerPixel: height / Math.max(1, this.canvas.clientHeight), distance };
  }

  // Before a picture, not after it: a change of size waits for all that was drawn.
  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    const ratio = this.renderer.getPixelRatio();
    if (this.canvas.width === Math.floor(clientWidth * ratio) && this.canvas.height === Math.floor(clientHeight * ratio)) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.changed = true;
  }

  // Takes the world's state over; draw() shows it.
  update(layers: Layers): void {
    const { positions, rotations, roles, moving, isOtherProxy } = this.world;
    let solids = 0, outsides = 0;
    for (const group of this.groups) {
      let solid = 0, edge = 0, outside = 0;
      group.solidBodies.length = group.edgeBodies.length = group.outsideBodies.length = 0;
      for (const i of group.bodies) {
        const role = roles[i]!;
        const member = (role & Role.member) !== 0;
        if ((role & Role.unknown) !== 0 || (member ? !layers.members : !layers.outside)) continue;
        const kind = kindOf(role, isOtherProxy[i]!);
        if (member || !kLegend[kind].see_through) {
          place(group.solid, solid++, i, positions, rotations, kColour[kind]);
          group.solidBodies.push(i);
        } else {
          place(group.outside, outside++, i, positions, rotations, kColour[kind]);
          group.outsideBodies.push(i);
        }
        const edges = moving[i] === this.highlighted ? kPointedEdge : kEdge[kind];
        if (edges === null) continue;
        place(group.edges, edge++, i, positions, rotations, edges);
        group.edgeBodies.push(i);
      }
      for (const [mesh, count] of [[group.solid, solid], [group.edges, edge], [group.outside, outside]] as const) {
        mesh.count = count;
        mesh.visible = count > 0;
        if (count === 0) continue;
        // Of what is shown alone: all of three meshes would go to the graphics card in every picture.
        for (const [attribute, size] of [[mesh.instanceMatrix, 16], [mesh.instanceColor!, 3]] as const) {
          attribute.clearUpdateRanges();
          attribute.addUpdateRange(0, size * count);
          attribute.needsUpdate = true;
        }
        mesh.boundingSphere = null; // of the poses before: a ray would miss
      }
      solids += solid;
      outsides += outside;
    }
    this.fixed.visible = layers.fixed;
    this.updateCube(layers);
    this.updateArrows(layers);
    this.canvas.dataset.world_s = String(this.world.time_s); // of the bodies' poses that are drawn
    this.canvas.dataset.solid = String(solids);
    this.canvas.dataset.outside = String(outsides);
    this.changed = true;
  }

  // The boundary cube: what reaches into it can be touched before the next members are there, and is a member already.
  private updateCube(layers: Layers): void {
    const { scene, indexOf, positions, rotations } = this.world;
    const at = indexOf[scene.proxy]!, shape = scene.shapes[scene.bodies[scene.proxy]!.shape]!;
    this.cube.visible = layers.cube && scene.reach_m > 0;
    this.cube.position.fromArray(positions, 3 * at);
    this.cube.scale.setScalar(halfSide(shape, new THREE.Quaternion().fromArray(rotations, 4 * at)) + scene.reach_m);
    this.canvas.dataset.cube_mm = this.cube.visible ? (1e3 * this.cube.scale.x).toFixed(2) : "none";
  }

  private updateArrows(layers: Layers): void {
    const line = this.arrows.geometry.getAttribute("position") as THREE.BufferAttribute;
    const matrix = new THREE.Matrix4(), up = new THREE.Vector3(0, 1, 0), one = new THREE.Vector3(1, 1, 1);
    let count = 0;
    if (layers.forces)
      for (const { point, force } of this.world.contacts) {
        if (count === kMaxArrows) break;
        const along = new THREE.Vector3(...force).multiplyScalar(layers.metresPerNewton);
        const from = new THREE.Vector3(...point), to = from.clone().add(along);
        line.setXYZ(2 * count, from.x, from.y, from.z);
        line.setXYZ(2 * count + 1, to.x, to.y, to.z);
        const rotation = new THREE.Quaternion().setFromUnitVectors(up, along.lengthSq() > 0 ? along.normalize() : up);
        this.heads.setMatrixAt(count++, matrix.compose(to, rotation, one));
      }
    line.needsUpdate = true;
    this.arrows.geometry.setDrawRange(0, 2 * count);
    this.heads.count = count;
    this.heads.visible = this.arrows.visible = count > 0;
    this.heads.instanceMatrix.needsUpdate = true;
    this.canvas.dataset.arrows = String(count);
  }

  // The device's target and the spring to the proxy, from a tick's channels.
  showDevice(row: Float32Array): void {
    const target: [number, number, number] = [row[7]!, row[8]!, row[9]!], proxy: [number, number, number] = [row[4]!, row[5]!, row[6]!];
    this.target.position.set(...target);
    const line = this.spring.geometry.getAttribute("position") as THREE.BufferAttribute;
    line.setXYZ(0, ...target);
    line.setXYZ(1, ...proxy);
    line.needsUpdate = true;
    this.changed = true;
  }

  // What a body is drawn as: its colour, its edges', and whether it is seen through; null: it is left out.
  look(body: number): { colour: string; edge: string; see_through: boolean } | null {
    const index = this.world.indexOf[body]!;
    const colourIn = (mesh: THREE.InstancedMesh, bodies: number[]): string => {
      const at = bodies.indexOf(index), colour = new THREE.Color();
      if (at < 0 || !mesh.visible || at >= mesh.count) return "";
      mesh.getColorAt(at, colour);
      return `#${colour.getHexString()}`;
    };
    for (const group of this.groups) {
      const solid = colourIn(group.solid, group.solidBodies), outside = colourIn(group.outside, group.outsideBodies);
      if (solid !== "" || outside !== "") return { colour: solid || outside, edge: colourIn(group.edges, group.edgeBodies), see_through: solid === "" };
    }
    return null;
  }

  // Where a body is drawn: x y z [m], and its rotation x y z w; null: it is left out.
  drawn(body: number): number[] | null {
    const index = this.world.indexOf[body]!, matrix = new THREE.Matrix4();
    for (const group of this.groups)
      for (const [mesh, bodies] of [[group.solid, group.solidBodies], [group.outside, group.outsideBodies]] as const) {
        const at = bodies.indexOf(index);
        if (at < 0) continue;
        mesh.getMatrixAt(at, matrix);
        const position = new THREE.Vector3(), rotation = new THREE.Quaternion();
        matrix.decompose(position, rotation, new THREE.Vector3());
        return [...position.toArray(), ...rotation.toArray()];
      }
    return null;
  }

  // The id of the body under a point of the canvas, in CSS pixels; -1: none.
  pick(x: number, y: number): number {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight), this.camera);
    let nearest = Infinity, body = -1;
    for (const group of this.groups)
      for (const [mesh, bodies] of [[group.solid, group.solidBodies], [group.outside, group.outsideBodies]] as const) {
        const hit = mesh.visible ? ray.intersectObject(mesh)[0] : undefined;
        if (hit === undefined || hit.instanceId === undefined || hit.distance >= nearest) continue;
        nearest = hit.distance;
        body = this.world.moving[bodies[hit.instanceId]!]!;
      }
    return body;
  }

  draw(): void {
    this.resize();
    if (!this.changed) return;
    this.changed = false;
    this.renderer.render(this.scene, this.camera);
    this.canvas.dataset.calls = String(this.renderer.info.render.calls);
  }
}
