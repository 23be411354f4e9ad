// MuJoCo, as its package is built: double precision, one thread.
//
// The scene becomes an MJCF model. Rods are heavy free bodies: each gets its velocity before a step and its pose after
// it. MuJoCo's mocap bodies have no velocity in contacts.
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "tools/experiment/engine.h"
#include "tools/experiment/scene_shapes.h"

namespace tactus::experiment {
namespace {

// MuJoCo 2.2 allocates its constraint matrices, rows x rows and rows x velocities, for the largest number of contacts:
// 2 GB of address space for a hundred bodies, 200 GB for a thousand.
constexpr std::size_t kMostBodies = 100;
constexpr std::size_t kRoomForContacts = 24, kRowsPerContact = 4;
constexpr double kRodMass_kg = 1000;

std::string numbers(const Vec3d& v) { return fmt::format("{:.17g} {:.17g} {:.17g}", v.x, v.y, v.z); }
std::string numbers(const Quatd& q) { return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}", q.w, q.x, q.y, q.z); }

std::string geometry(const BoxScene& scene, const Cube& body) {
  const physics::Shape shape = shape_of(scene, body);
  switch (shape.kind) {
    case physics::ShapeKind::kSphere:
      return fmt::format(R"(<geom type="sphere" size="{:.17g}"/>)", shape.radius);
    case physics::ShapeKind::kCapsule:
      return fmt::format(R"(<geom type="capsule" size="{:.17g} {:.17g}"/>)", shape.radius, shape.half_length);
    case physics::ShapeKind::kHull:
      return fmt::format(R"(<geom type="mesh" mesh="hull{}"/>)", shape.index);
    default:
      return fmt::format(R"(<geom type="box" size="{}"/>)", numbers(shape.half_extents));
  }
}

std::string model_of(const BoxScene& scene, const EngineOptions& options) {
  const std::size_t bodies = scene.cubes.size() + rods_of(scene), contacts = kRoomForContacts * bodies;
  std::string xml =
      fmt::format(R"(<mujoco><compiler inertiafromgeom="false"/><size nconmax="{}" njmax="{}" nstack="{}"/>
<option timestep="{:.17g}" gravity="0 0 {:.17g}")",
                  contacts, kRowsPerContact * contacts, 4'000'000, scene.step_s, -scene.gravity_m_per_s2);
  if (options.tuned) xml += R"( cone="elliptic")";
  if (options.iterations > 0) xml += fmt::format(R"( iterations="{}")", options.iterations);
  xml += fmt::format(R"(/>
<default><geom friction="{:.17g} 0 0")",
                     scene.friction);
  // Tuned: contacts as stiff as the step allows; with the elliptic cone a settled heap then takes less time than with
  // the pyramid, at a tenth of the overlap of the defaults. No setting holds a stack of 20 cubes in steps of 1 ms
  // whatever its start: tried were both cones, Newton, conjugate gradient and projected Gauss-Seidel, impratio 1 to
  // 100, no-slip iterations, implicit integration, and 2 to 6 steps; a start that differs by rounding decides if it
  // falls.
  if (options.tuned) xml += fmt::format(R"( solref="{:.17g} 1")", 2 * scene.step_s);
  xml += "/></default>\n<asset>\n";
  for (std::size_t i = 0; i < scene.hulls.size(); ++i) {
    xml += fmt::format(R"(<mesh name="hull{}" vertex=")", i);
    for (std::uint32_t v = 0; v < scene.hulls[i].topology.vertices; ++v) xml += numbers(scene.hulls[i].vertex(v)) + " ";
    xml += "\"/>\n";
  }
  xml += "</asset>\n<worldbody>\n";
  for (const Wall& wall : scene.walls)
    xml += fmt::format("<geom type=\"box\" size=\"{}\" pos=\"{}\" quat=\"{}\"/>\n", numbers(wall.half_extents_m),
                       numbers(wall.position), numbers(wall.rotation));
  const auto add_body = [&](const Posed& at, double mass, const Vec3d& inertia, const std::string& geometry) {
    xml += fmt::format(
        "<body pos=\"{}\" quat=\"{}\"><freejoint/><inertial pos=\"0 0 0\" mass=\"{:.17g}\" "
        "diaginertia=\"{}\"/>{}</body>\n",
        numbers(at.position), numbers(at.rotation), mass, numbers(inertia), geometry);
  };
  for (const Cube& cube : scene.cubes)
    add_body({cube.position, cube.rotation}, cube.mass_kg, inertia_of(scene, cube), geometry(scene, cube));
  for (std::size_t i = 0; i < rods_of(scene); ++i)
    add_body(scene.stirrer->pose_at(i, 0), kRodMass_kg, Vec3d{kRodMass_kg, kRodMass_kg, kRodMass_kg},
             fmt::format(R"(<geom type="box" size="{}"/>)", numbers(scene.stirrer->half_extents_m)));
  return xml + "</worldbody></mujoco>\n";
}

class MujocoEngine final : public Engine {
 public:
  MujocoEngine(const BoxScene& scene, const EngineOptions& options)
      : cubes_(scene.cubes.size()), rods_(rods_of(scene)), stirrer_(scene.stirrer), step_s_(scene.step_s) {
    const std::string xml = model_of(scene, options);
    const char* name = "scene.xml";
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), name, static_cast<int>(xml.size()));
    std::memcpy(files->filedata[0], xml.data(), xml.size());
    char error[500] = "";
    model_.reset(mj_loadXML(name, files.get(), error, sizeof(error)));
    mj_deleteVFS(files.get());
    if (!model_) throw std::runtime_error(fmt::format("MuJoCo does not take the scene: {}", error));
    data_.reset(mj_makeData(model_.get()));
  }

  void step() override {
    for (std::size_t i = 0; i < rods_; ++i) {
      const Twistd velocity = stirrer_->velocity_over(i, pose_of(cubes_ + i).position, time_s_, step_s_);
      const Vec3d &v = velocity.linear, &w = velocity.angular;
      std::copy_n(std::array<mjtNum, 6>{v.x, v.y, v.z, w.x, w.y, w.z}.begin(), 6, data_->qvel + 6 * (cubes_ + i));
    }
    mj_step(model_.get(), data_.get());
    time_s_ += step_s_;
    for (std::size_t i = 0; i < rods_; ++i) {
      const auto [p, r] = stirrer_->pose_at(i, time_s_);
      std::copy_n(std::array<mjtNum, 7>{p.x, p.y, p.z, r.w, r.x, r.y, r.z}.begin(), 7, data_->qpos + 7 * (cubes_ + i));
    }
  }

  Measurement measure() override {
    Measurement m;
    m.contacts = data_->ncon;
    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i < data_->ncon; ++i) {
      const mjContact& contact = data_->contact[i];
      if (contact.dist <= 0) pairs.emplace_back(contact.geom1, contact.geom2);
    }
    std::sort(pairs.begin(), pairs.end());
    m.touching_pairs = static_cast<double>(std::unique(pairs.begin(), pairs.end()) - pairs.begin());
    m.residual_speed_m_per_s = residual_speed(cubes());
    return m;
  }

  std::vector<CubeState> cubes() const override {
    std::vector<CubeState> states;
    states.reserve(cubes_);
    for (std::size_t i = 0; i < cubes_; ++i) {
      const Posed pose = pose_of(i);
      const mjtNum* v = data_->qvel + 6 * i;
      states.push_back({pose.position, {v[0], v[1], v[2]}, pose.rotation});
    }
    return states;
  }

  std::vector<Posed> rods() const override {
    std::vector<Posed> poses;
    for (std::size_t i = 0; i < rods_; ++i) poses.push_back(pose_of(cubes_ + i));
    return poses;
  }

  std::string settings() const override {
    const mjOption& option = model_->opt;
    const bool tuned = option.cone == mjCONE_ELLIPTIC;
    return fmt::format("double precision, Newton's method, {} cone, at most {} iterations, solref {:g} s{}",
                       tuned ? "elliptic" : "pyramidal", option.iterations, model_->geom_solref[0],
                       tuned ? "" : ", defaults");
  }

  std::string failure() const override {
    for (const int warning : {mjWARN_CONTACTFULL, mjWARN_CNSTRFULL, mjWARN_BADQACC, mjWARN_BADQPOS, mjWARN_BADQVEL})
      if (data_->warning[warning].number > 0)
        return fmt::format("MuJoCo warns: {}", mju_warningText(warning, data_->warning[warning].lastinfo));
    return {};
  }

 private:
  struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  // By body: seven numbers of position and rotation, six of velocity.
  Posed pose_of(std::size_t body) const {
    const mjtNum* q = data_->qpos + 7 * body;
    return {{q[0], q[1], q[2]}, {q[3], q[4], q[5], q[6]}};
  }

  std::size_t cubes_, rods_;
  std::optional<Stirrer> stirrer_;
  double step_s_, time_s_{0};
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
};

}  // namespace

std::unique_ptr<Engine> make_mujoco(const BoxScene& scene, const EngineOptions& options) {
  return std::make_unique<MujocoEngine>(scene, options);
}

bool mujoco_takes(const BoxScene& scene) {
  return !scene.terrain && scene.cubes.size() + rods_of(scene) <= kMostBodies;
}

}  // namespace tactus::experiment
