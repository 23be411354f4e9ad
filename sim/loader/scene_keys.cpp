#include "sim/loader/scene_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sim/model/scene_effects.h"

namespace tactus::sim {
namespace {

struct Meaning {
  std::string_view table, key, text, fallback;
};

// In the order of the documentation. Keys that several tables share are listed once, under the table "body", "surface"
// or "pose".
constexpr Meaning kMeanings[] = {
    {"", "title", "one line for people", ""},
    {"", "effects", "the effects that the scene calls for, by their names; all others cost nothing", "none"},
    {"", "gravity_m_per_s2", "acceleration of gravity, world frame; needs the effect gravity", ""},
    {"", "proxy", "the body that the device holds; [[proxy]]: one for each hand", ""},
    {"", "body", "a body each", ""},
    {"", "generate", "many bodies each, by a generator", ""},
    {"", "joint", "a joint each; needs the effect joints", ""},
    {"", "attraction", "a source each that attracts bodies; needs the effect attraction", ""},
    {"", "simulation", "how both worlds are stepped", ""},
    {"", "sleeping", "when bodies at rest fall asleep; needs the effect sleeping", ""},
    {"", "damping", "damping of every moving body; needs the effect damping", ""},
    {"", "drag", "drag of a fluid on every moving body; needs the effect drag", ""},
    {"", "device", "where the device is in the scene, and which one is simulated; or [[device]] for each hand", ""},
    {"", "coupling", "the spring and damper between device and proxy; or [[coupling]] for each hand", ""},
    {"", "hand", "the simulated hand that holds the simulated device; or [[hand]] for each", ""},
    {"", "hull_file", "written by tactus into a tape: the vertices of a hull's file", ""},
    {"", "mesh_file", "written by tactus into a tape: the triangles of a mesh's file", ""},

    {"", "motion_file", "written by tactus into a tape: the rows of the hand's file", ""},

    {"[simulation]", "ratio", "ticks of the haptic loop in one step of the global world", ""},
    {"[simulation]", "members", "most bodies of the haptic sub-world, the proxy included", ""},
    {"[simulation]", "sub_steps", "sub-steps of a tick in the haptic sub-world", ""},
    {"[simulation]", "relax_sweeps", "sweeps without bias after each sub-step in the haptic sub-world", ""},
    {"[simulation]", "friction_sweeps",
     "friction in the relax sweep or in every sweep; auto: in every sweep where there are two relax sweeps or more",
     ""},
    {"[simulation]", "global_sub_steps_per_tick", "sub-steps of the global world for each tick; may be a fraction", ""},
    {"[simulation]", "far_sub_steps_per_tick",
     "the same for islands without a member and out of the proxy's reach; at most global_sub_steps_per_tick",
     "global_sub_steps_per_tick"},
    {"[simulation]", "contact_hertz_Hz",
     "natural frequency of contacts, their stiffness over the mass: at most 250 Hz times the smallest number of "
     "sub-steps in a tick",
     ""},
    {"[simulation]", "contact_damping_ratio", "damping of contacts, of the critical one", ""},

    {"[sleeping]", "max_speed_m_per_s", "speed of a body's surface below which it counts as at rest", ""},
    {"[sleeping]", "after_s", "time at rest after which an island falls asleep", ""},
    {"[sleeping]", "from_start", "what does not move at the start sleeps until something comes near", ""},

    {"[damping]", "linear_per_s", "rate at which a velocity decays", ""},
    {"[damping]", "angular_per_s", "rate at which an angular velocity decays", ""},

    {"[drag]", "fluid_density_kg_per_m3", "density of the fluid", ""},
    {"[drag]", "coefficient", "drag coefficient; the area across the flow is a quarter of the body's surface", ""},
    {"[drag]", "flow_m_per_s", "velocity of the fluid, world frame", ""},

    {"[device]", "profile", "the device that is simulated: six axes with torque, or three axes without", ""},
    {"[device]", "motion_scale",
     "the proxy's motion over the device's; the force on the hand is that times the force in the scene", ""},

    {"[coupling]", "stiffness_N_per_m", "stiffness of translation, at the device", ""},
    {"[coupling]", "damping_Ns_per_m", "damping of translation, at the device", ""},
    {"[coupling]", "stiffness_Nm_per_rad", "stiffness of rotation", ""},
    {"[coupling]", "damping_Nms_per_rad", "damping of rotation", ""},

    {"[hand]", "path", "way points: between two the target goes along 10u^3 - 15u^4 + 6u^5 and rests at each",
     "rests at the proxy"},
    {"[hand]", "repeat", "the motion starts again at its end; its last pose is then its first",
     "true; false with a file"},
    {"[hand]", "file",
     "a recorded motion, CSV, in place of a path: time_s,position_x_m,position_y_m,position_z_m and, if it turns, "
     "rotation_w,rotation_x,rotation_y,rotation_z (world_from_tool); from the scene's folder",
     "none"},
    {"[hand]", "interpolation", "between the rows of a file", ""},
    {"[hand]", "stiffness_N_per_m", "stiffness of the arm in translation", ""},
    {"[hand]", "damping_Ns_per_m", "damping of the arm in translation", ""},
    {"[hand]", "stiffness_Nm_per_rad", "stiffness of the arm in rotation", ""},
    {"[hand]", "damping_Nms_per_rad", "damping of the arm in rotation", ""},
    {"[hand]", "mass_kg", "mass of the hand, added to the device's", ""},
    {"[hand] path", "time_s", "time since the path's start; ascending, the first 0", ""},
    {"[hand] path", "position_m", "the hand's target, world frame", ""},
    {"[hand] path", "rotation_vector_rad", "rotation of the tool, as axis times angle, world frame", ""},

    {"body", "shape", "the body's shape", ""},
    {"body", "size_m", "full lengths of the edges", ""},
    {"body", "radius_m", "radius", ""},
    {"body", "length_m", "from the centre of one cap to that of the other, along z", ""},
    {"body", "points_m", "points whose convex hull the body is; at most 64 vertices remain, at least 0.1 mm thick",
     "none: or file"},
    {"body", "file", "file of the points or triangles: .obj or .stl, from the scene's folder",
     "none; a mesh needs one"},
    {"body", "file_unit_m", "the length that the file calls 1: 0.001 for millimetres", ""},
    {"body", "mass_kg", "mass; or density_kg_per_m3", "none: one of the two"},
    {"body", "density_kg_per_m3", "density: mass, centre and inertia are those of the solid", "none: or mass_kg"},
    {"body", "inertia_kg_m2",
     "moments of inertia about the centre of mass, along the frame's axes: [xx, yy, zz]; of a hull also [xx, yy, zz, "
     "xy, xz, yz]",
     "those of the solid"},
    {"body", "centre_of_mass_m", "centre of mass in the body's frame; with inertia_kg_m2", "the solid's"},
    {"body", "velocity_m_per_s", "velocity at the start, world frame", ""},
    {"body", "angular_velocity_rad_per_s", "angular velocity at the start, world frame", ""},
    {"body", "name", "a name for joints, attraction and messages; each body its own", ""},
    {"body", "fixed", "the body never moves", "false; planes and meshes always are"},
    {"body", "kinematic", "follows its velocity or path whatever touches it; needs no mass; the effect kinematic", ""},
    {"body", "path", "way points of a kinematic body, in place of its pose and velocity", ""},
    {"body", "repeat_path", "the path starts again at its end", ""},
    {"[[body]] path", "time_s", "time since the scene's start; ascending, the first 0", ""},
    {"[[body]] path", "position_m", "place of the body's frame, world frame", ""},
    {"[[body]] path", "rotation_vector_rad", "rotation as axis times angle, world frame", ""},

    {"[[generate]]", "kind", "the generator", ""},
    {"[[generate]]", "columns", "bricks of a course", ""},
    {"[[generate]]", "rows", "courses", ""},
    {"[[generate]]", "brick_m", "a brick's edges: along the wall, through it, up", ""},
    {"[[generate]]", "gap_m", "between bricks of a course, or between flat cards of a level", ""},
    {"[[generate]]", "mass_kg", "mass of each body (half bricks weigh half)", ""},
    {"[[generate]]", "count", "bodies", ""},
    {"[[generate]]", "layers", "layers", ""},
    {"[[generate]]", "cube_m", "edge of a cube", ""},
    {"[[generate]]", "gap_fraction", "gap between neighbours of a layer, of the cube's edge", ""},
    {"[[generate]]", "wall_height_m", "height of the fixed walls around the heap", "cube_m x (layers + 2)"},
    {"[[generate]]", "wall_thickness_m", "thickness of these walls", "cube_m"},
    {"[[generate]]", "seed", "seed of the jitter of places and yaw", ""},
    {"[[generate]]", "blocks_per_layer", "1: a stack; more: side by side, every other layer turned by a quarter turn",
     ""},
    {"[[generate]]", "block_m", "a block's edges", ""},
    {"[[generate]]", "levels", "levels", ""},
    {"[[generate]]", "card_m", "a card's short edge, long edge and thickness", ""},
    {"[[generate]]", "angle_rad", "angle of a leaning card from the vertical", ""},
    {"[[generate]]", "domino_m", "a domino's edges: thickness along the row, width, height", ""},
    {"[[generate]]", "spacing_m", "from centre to centre", ""},
    {"[[generate]]", "copies_x", "copies of the whole part along x, about its place", ""},
    {"[[generate]]", "copies_y", "copies along y", ""},
    {"[[generate]]", "copy_pitch_m", "distance of copies", ""},

    {"pose", "position_m", "place of the frame in the world", ""},
    {"pose", "rotation_vector_rad", "rotation of the frame in the world, as axis times angle", ""},

    {"surface", "friction", "coefficient of Coulomb friction; a pair has the geometric mean; the effect friction", ""},
    {"surface", "restitution",
     "coefficient of restitution above 0.05 m/s; a pair has the larger; the effect restitution", ""},
    {"surface", "contact_radius_m",
     "a contact of one point resists a spin as a disk of that radius: 2/3 mu N R; the effect torsional", ""},
    {"surface", "rolling_friction_m", "resists rolling by the normal force times that length; the effect rolling", ""},
    {"surface", "attraction_weight", "how strongly a source attracts it; the effect attraction", ""},
    {"surface", "texture_height_m", "height of the grain that the hand feels; the effect texture", ""},
    {"surface", "texture_wavelength_m", "wavelength of the grain", ""},
    {"surface", "transient_strength_Ns_per_m",
     "force that rings in the hand, for each metre per second of the impact; the effect transients", ""},
    {"surface", "transient_frequency_Hz", "frequency of that ringing", ""},
    {"surface", "transient_decay_s", "time in which it decays to 1/e", ""},

    {"[[joint]]", "kind", "which motions the joint leaves free", ""},
    {"[[joint]]", "a", "name of the first body, or \"proxy\"; those of further hands are \"proxy2\" and so on",
     "the world"},
    {"[[joint]]", "b", "name of the second body, which moves", ""},
    {"[[joint]]", "position_m", "place of the joint at the start, world frame", "the place of b"},
    {"[[joint]]", "position_a_m", "end at a, at the start, world frame", "the place of a"},
    {"[[joint]]", "position_b_m", "end at b, at the start, world frame", "the place of b"},
    {"[[joint]]", "axis", "direction of the axis at the start, world frame", ""},
    {"[[joint]]", "bodies_collide", "a and b collide with each other", ""},
    {"[[joint]]", "low_rad", "lower limit; without both limits the joint turns freely", ""},
    {"[[joint]]", "high_rad", "upper limit", ""},
    {"[[joint]]", "low_m", "lower limit; a rope has 0", ""},
    {"[[joint]]", "high_m", "upper limit", ""},
    {"[[joint]]", "length_m", "distance that is kept; or low_m and high_m", "the distance at the start"},
    {"[[joint]]", "motor_speed_rad_per_s", "speed that the motor seeks", ""},
    {"[[joint]]", "motor_torque_Nm", "most torque of the motor; there is a motor where this is set", "no motor"},
    {"[[joint]]", "motor_speed_m_per_s", "speed that the motor seeks", ""},
    {"[[joint]]", "motor_force_N", "most force of the motor; there is a motor where this is set", "no motor"},
    {"[[joint]]", "break_force_N", "mean force over a step that breaks the joint for good", "never breaks"},
    {"[[joint]]", "break_torque_Nm", "mean torque over a step that breaks it for good", "never breaks"},

    {"[[attraction]]", "body", "name of the body that attracts; or position_m", "none"},
    {"[[attraction]]", "position_m", "place of the source, world frame", ""},
    {"[[attraction]]", "strength_Nm2", "force = strength x weight / distance^2; below 0 it repels", ""},
    {"[[attraction]]", "softening_m", "distance is taken as sqrt(d^2 + softening^2)", ""},

    {"[[hull_file]]", "name", "the file's name, as a body has it", ""},
    {"[[hull_file]]", "file_unit_m", "the length that the file calls 1", ""},
    {"[[hull_file]]", "points_m", "the hull's vertices", ""},
    {"[[motion_file]]", "name", "the file's name, as [hand] has it", ""},
    {"[[motion_file]]", "rows", "time, position, rotation (w, x, y, z): eight numbers a row", ""},
    {"[[mesh_file]]", "name", "the file's name, as a body has it", ""},
    {"[[mesh_file]]", "file_unit_m", "the length that the file calls 1", ""},
    {"[[mesh_file]]", "corners_m", "x, y, z of each corner", ""},
    {"[[mesh_file]]", "triangles", "three numbers of corners each, from 0", ""},
};

struct Purpose {
  std::string_view table, text;
};
constexpr Purpose kPurposes[] = {
    {"", "The file's own keys, before its first table."},
    {"[simulation]", "How both worlds are stepped."},
    {"[proxy]", "The body that the device holds at its centre of mass. Gravity does not act on it."},
    {"[[body]]", "One body. Planes and meshes are fixed."},
    {"[[body]] path", "A way point of a kinematic body."},
    {"[[generate]]", "Many bodies: a brick wall, a heap of cubes in a box, a tower, a card house, a row of dominoes."},
    {"[[joint]]", "Holds two bodies to each other, or one to the world."},
    {"[device]", "Where the device's frame is in the scene (its pose), and which device is simulated."},
    {"[coupling]", "The spring and damper between device and proxy. tactus run lowers what would not be stable."},
    {"[hand]", "The simulated hand: the impedance of an arm that follows a path."},
    {"[hand] path", "A way point of the hand."},
    {"[sleeping]", "When bodies at rest fall asleep in the global world."},
    {"[damping]", "Damping of every moving body."},
    {"[drag]", "Drag of a fluid: 1/2 density x coefficient x area x speed^2."},
    {"[[attraction]]", "A source that attracts bodies, as a magnet does."},
    {"[[hull_file]]", "In tapes alone: a hull's file, so that a tape replays without it."},
    {"[[motion_file]]", "In tapes alone: the hand's file, so that a tape replays without it."},
    {"[[mesh_file]]", "In tapes alone: a mesh's file, so that a tape replays without it."},
};

constexpr std::array kShapes{"sphere", "capsule", "box", "hull", "plane", "mesh"};
constexpr std::array kGenerators{"wall", "pile", "tower", "card_house", "domino_row"};
constexpr std::array kJoints{"fixed", "ball", "hinge", "slider", "distance"};

// The head of a scene that declares every effect; one variant of a table is appended at a time.
std::string head() {
  std::string effects;
  for (const auto& effect : known_effects()) effects += fmt::format("\"{}\", ", effect.name);
  return "effects = [" + effects +
         "]\n[simulation]\nglobal_sub_steps_per_tick = 16\n[[hull_file]]\n[[mesh_file]]\nname = \"a.stl\"\n"
         "corners_m = [0, 0, 0, 1, 0, 0, 0, 1, 0]\ntriangles = [0, 1, 2]\n"
         "[[motion_file]]\nname = \"a.csv\"\nrows = [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]\n[proxy]\nshape = "
         "\"sphere\"\n";
}

struct Variant {
  std::string_view table;
  std::string name, text;
};

std::vector<Variant> variants() {
  const std::string pointed = "points_m = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
  std::vector<Variant> all;
  for (const std::string shape : kShapes) {
    std::string text = fmt::format("{}[[body]]\nshape = \"{}\"\n", head(), shape);
    if (shape == "mesh") text += "file = \"a.stl\"\n";
    // With points, then with a file: the loader requests only one of the two at a time.
    if (shape == "hull") {
      all.push_back({"[[body]]", shape, text + "file = \"a.stl\"\n"});
      text += pointed;
    }
    all.push_back({"[[body]]", shape, text});
    all.push_back({"[[body]]", shape,
                   text + "kinematic = true\nrepeat_path = true\npath = [{time_s = 0, position_m = [0, 0, 0]}]\n"});
    if (shape != "plane" && shape != "mesh") {
      std::string proxy = fmt::format("[proxy]\nshape = \"{}\"\n", shape);
      if (shape == "hull") {
        all.push_back({"[proxy]", shape, proxy + "file = \"a.stl\"\n"});
        proxy += pointed;
      }
      all.push_back({"[proxy]", shape, proxy});
    }
  }
  for (const std::string kind : kGenerators)
    all.push_back({"[[generate]]", kind, fmt::format("{}[[generate]]\nkind = \"{}\"\n", head(), kind)});
  for (const std::string kind : kJoints)
    all.push_back({"[[joint]]", kind,
                   fmt::format("{}[[joint]]\nkind = \"{}\"\nb = \"proxy\"\nbreak_force_N = 1\nbreak_torque_Nm = 1\n",
                               head(), kind)});
  all.push_back({"[hand]", "path", head() + "[hand]\npath = [{time_s = 0, position_m = [0, 0, 0]}]\n"});
  all.push_back({"[hand]", "file", head() + "[hand]\nfile = \"a.csv\"\n"});
  all.push_back({"", "", head() + "[[attraction]]\n"});
  return all;
}

const Meaning* find_meaning(std::string_view table, std::string_view key) {
  for (const auto& m : kMeanings)
    if (m.table == table && m.key == key) return &m;
  return nullptr;
}

// The entry of the key's own table, else the shared one of bodies, surfaces or poses.
const Meaning* meaning_of(const text::AskedKey& asked) {
  if (const Meaning* own = find_meaning(asked.table, asked.key)) return own;
  const bool is_body = asked.table == "[[body]]" || asked.table == "[proxy]";
  const bool has_surface = is_body || asked.table == "[[generate]]";
  if (is_body)
    if (const Meaning* m = find_meaning("body", asked.key)) return m;
  if (has_surface)
    if (const Meaning* m = find_meaning("surface", asked.key)) return m;
  if (has_surface || asked.table == "[device]") return find_meaning("pose", asked.key);
  return nullptr;
}

struct Found {
  text::AskedKey asked;
  std::vector<std::string> with;  // the variants of its table that have it
};

// The same key with different defaults or ranges, as in generators and joints, is a separate row, unless the default is
// given in words.
bool is_same(const text::AskedKey& a, const text::AskedKey& b) {
  if (a.table != b.table || a.key != b.key) return false;
  const Meaning* meaning = meaning_of(a);
  const bool said = meaning != nullptr && !meaning->fallback.empty();
  return said || a.type == text::AskedKey::Type::kUnknown || b.type == text::AskedKey::Type::kUnknown ||
         (a.fallback == b.fallback && a.low == b.low && a.high == b.high);
}

std::vector<Found> ask_everything(std::vector<std::pair<std::string, std::string>>& tried) {
  std::vector<Found> found;
  for (const Variant& variant : variants()) {
    const std::pair<std::string, std::string> name{variant.table, variant.name};
    if (std::find(tried.begin(), tried.end(), name) == tried.end()) tried.push_back(name);
    for (text::AskedKey& asked : asked_keys(variant.text)) {
      const auto same = [&](const Found& f) { return is_same(f.asked, asked); };
      auto at = std::find_if(found.begin(), found.end(), same);
      if (at == found.end()) at = found.insert(found.end(), Found{asked, {}});
      if (at->asked.type == text::AskedKey::Type::kUnknown) at->asked = asked;
      if (asked.table != variant.table) continue;
      if (at->with.empty() || at->with.back() != variant.name) at->with.push_back(variant.name);
    }
  }
  return found;
}

std::size_t order_of(const text::AskedKey& asked) {
  const Meaning* meaning = meaning_of(asked);
  return meaning == nullptr ? std::size(kMeanings) : static_cast<std::size_t>(meaning - kMeanings);
}

// "box, hull"; empty if all variants of the table have the key.
std::string some_of(const std::vector<std::string>& with, std::size_t variants_of_table) {
  std::string list;
  if (with.size() < variants_of_table)
    for (const std::string& name : with) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace

std::span<const EitherKey> either_keys() noexcept {
  static constexpr EitherKey kEither[] = {{"[[body]]", "", "mass_kg", "density_kg_per_m3", true},
                                          {"[proxy]", "", "mass_kg", "density_kg_per_m3", true},
                                          {"[[body]]", "hull", "points_m", "file", true},
                                          {"[proxy]", "hull", "points_m", "file", true},
                                          {"[hand]", "", "path", "file", false}};
  return kEither;
}

std::vector<SceneTable> scene_language() {
  std::vector<std::pair<std::string, std::string>> tried;
  const auto found = ask_everything(tried);
  std::vector<SceneTable> language;
  for (const Purpose& purpose : kPurposes)
    language.push_back({std::string(purpose.table), std::string(purpose.text), {}});
  for (const Found& f : found) {
    auto table = std::find_if(language.begin(), language.end(), [&](const auto& t) { return t.name == f.asked.table; });
    if (table == language.end()) table = language.insert(language.end(), {f.asked.table, "", {}});
    const auto variants_of_table = static_cast<std::size_t>(
        std::count_if(tried.begin(), tried.end(), [&](const auto& v) { return v.first == f.asked.table; }));
    SceneKey key{f.asked, some_of(f.with, variants_of_table), "", f.asked.fallback};
    if (const Meaning* meaning = meaning_of(f.asked)) {
      key.meaning = meaning->text;
      if (!meaning->fallback.empty()) {
        key.fallback = meaning->fallback;
        key.asked.required = false;
      }
    }
    if (key.asked.required) key.fallback.clear();
    table->keys.push_back(std::move(key));
  }
  for (SceneTable& table : language)
    std::stable_sort(table.keys.begin(), table.keys.end(),
                     [](const SceneKey& a, const SceneKey& b) { return order_of(a.asked) < order_of(b.asked); });
  return language;
}

std::vector<std::string> superfluous_meanings() {
  std::vector<std::pair<std::string, std::string>> tried;
  const auto found = ask_everything(tried);
  std::vector<std::string> list;
  for (const Meaning& meaning : kMeanings)
    if (std::none_of(found.begin(), found.end(), [&](const Found& f) { return meaning_of(f.asked) == &meaning; }))
      list.push_back(fmt::format("{} {}", meaning.table, meaning.key));
  return list;
}

std::string type_of(const text::AskedKey& key) {
  switch (key.type) {
    case text::AskedKey::Type::kNumber:
      return "number";
    case text::AskedKey::Type::kCount:
    case text::AskedKey::Type::kSeed:
      return "whole number";
    case text::AskedKey::Type::kFlag:
      return "true or false";
    case text::AskedKey::Type::kText:
      return "text";
    case text::AskedKey::Type::kWord:
      return "one of";
    case text::AskedKey::Type::kVector:
      return "[x, y, z]";
    case text::AskedKey::Type::kTable:
      return "table";
    case text::AskedKey::Type::kArray:
      return "list";
    case text::AskedKey::Type::kUnknown:
      break;
  }
  return "";
}

std::string unit_of(const text::AskedKey& key) {
  static constexpr std::pair<std::string_view, std::string_view> kUnits[] = {{"_kg_per_m3", "kg/m3"},
                                                                             {"_Ns_per_m", "N s/m"},
                                                                             {"_Nms_per_rad", "N m s/rad"},
                                                                             {"_N_per_m", "N/m"},
                                                                             {"_Nm_per_rad", "N m/rad"},
                                                                             {"_rad_per_s", "rad/s"},
                                                                             {"_m_per_s2", "m/s2"},
                                                                             {"_m_per_s", "m/s"},
                                                                             {"_per_s", "1/s"},
                                                                             {"_kg_m2", "kg m2"},
                                                                             {"_Nm2", "N m2"},
                                                                             {"_Nm", "N m"},
                                                                             {"_N", "N"},
                                                                             {"_Hz", "Hz"},
                                                                             {"_rad", "rad"},
                                                                             {"_kg", "kg"},
                                                                             {"_s", "s"},
                                                                             {"_m", "m"}};
  for (const auto& [end, unit] : kUnits)
    if (key.key.size() > end.size() && std::string_view(key.key).substr(key.key.size() - end.size()) == end)
      return std::string(unit);
  return "";
}

std::string values_of(const text::AskedKey& key) {
  switch (key.type) {
    case text::AskedKey::Type::kNumber:
    case text::AskedKey::Type::kCount:
      return fmt::format("{:g} to {:g}", key.low, key.high);
    case text::AskedKey::Type::kVector:
      return fmt::format("each {:g} to {:g}", key.low, key.high);
    case text::AskedKey::Type::kSeed:
      return "0 and more";
    case text::AskedKey::Type::kText:
      return fmt::format("at most {:g} characters", key.high);
    case text::AskedKey::Type::kArray:
      return fmt::format("at most {:g}", key.high);
    case text::AskedKey::Type::kWord: {
      std::string list;
      for (const std::string& word : key.words) list += (list.empty() ? "" : ", ") + word;
      return list;
    }
    default:
      return "";
  }
}

}  // namespace tactus::sim
