// tactus itself: the world used by both sides. Up to the largest sub-world it has the broad phase and precision of the
// haptic side, above that those of the global world.
#include <fmt/format.h>

#include <algorithm>

#include "rt/base/denormals.h"
#include "rt/haptics/coupling/snapshot.h"
#include "sim/broad_phase/pair_cache.h"
#include "sim/model/choice_names.h"
#include "sim/worker_pool.h"
#include "tools/experiment/engine.h"
#include "tools/experiment/scene_shapes.h"
#include "tools/experiment/timing.h"

namespace tactus::experiment {
namespace {

constexpr std::uint32_t kPairsPerBody = 16, kContactsPerBody = 8;  // as in the global world
// With mixed sizes, a large body may have hundreds of small neighbours.
constexpr std::uint32_t kPairsPerMixedBody = 48, kContactsPerMixedBody = 16;
constexpr std::uint32_t kTrianglesPerBody = 64;  // of rough ground
constexpr double kLongStep_s = 5e-3;
constexpr double kMaxHertz = 250,
                 kHertzPerSubStep = 0.2;  // the most at which one relax sweep damps a column (contact/softness.h)

bool is_mixed(const BoxScene& scene) {
  return std::any_of(scene.cubes.begin(), scene.cubes.end(),
                     [&](const Cube& cube) { return cube.edge_m != scene.cubes.front().edge_m; });
}

// True if the scene is larger than the largest sub-world.
bool is_global(const BoxScene& scene) { return scene.cubes.size() + rods_of(scene) > haptics::kMaxMembers; }

physics::SweepPrecision precision_of(const BoxScene& scene, const EngineOptions& options) {
  return options.precision.value_or(is_global(scene) ? physics::SweepPrecision::kSingle
                                                     : physics::SweepPrecision::kFull);
}

physics::Capacities capacities_of(const BoxScene& scene) {
  const auto bodies = static_cast<std::uint32_t>(scene.cubes.size()) + rods_of(scene) + 1;
  const bool mixed = is_mixed(scene);
  return {.bodies = bodies,
          .fixed_bodies = static_cast<std::uint32_t>(scene.walls.size()) + 1,
          .pairs = (mixed ? kPairsPerMixedBody : kPairsPerBody) * bodies + 256,
          .contacts = (mixed ? kContactsPerMixedBody : kContactsPerBody) * bodies + 256,
          .border_contacts = 0,
          .mesh_triangles = scene.terrain ? kTrianglesPerBody * bodies : 0};
}

physics::StepSettings settings_of(const BoxScene& scene, unsigned sub_steps) {
  physics::StepSettings settings;
  settings.dt = scene.step_s;
  settings.sub_steps = sub_steps > 0 ? sub_steps : scene.step_s > kLongStep_s ? 10 : 4;
  settings.contact_hertz = std::min(kMaxHertz, kHertzPerSubStep * settings.sub_steps / scene.step_s);
  settings.gravity = scene.gravity_at(0);
  return settings;
}

// Rods follow the velocity set before each step, so their scripts have no way points.
std::vector<physics::KinematicScript> scripts_of(const BoxScene& scene) {
  std::vector<physics::KinematicScript> scripts;
  for (std::uint32_t i = 0; i < rods_of(scene); ++i)
    scripts.push_back({.id = static_cast<BodyId>(scene.cubes.size()) + i});
  return scripts;
}

physics::EffectSetups effects_of(const std::vector<physics::KinematicScript>& scripts) {
  physics::EffectSetups setups;
  std::get<physics::ScriptedMotion::Setup>(setups).scripts = scripts;
  return setups;
}

class TactusEngine final : public Engine {
 public:
  TactusEngine(const BoxScene& scene, const EngineOptions& options)
      : step_s_(scene.step_s),
        settings_(settings_of(scene, options.sub_steps)),
        is_global_(is_global(scene)),
        times_broad_phase_(options.time_broad_phase),
        scripts_(scripts_of(scene)),
        hulls_(scene.hulls),
        gravity_m_per_s2_(scene.gravity_m_per_s2),
        turning_(scene.turning),
        terrain_(scene.terrain),
        meshes_(terrain_ ? std::vector{terrain_->mesh} : std::vector<physics::Mesh>{}),
        world_(capacities_of(scene), physics::ShapeLists{hulls_, meshes_, {}}, effects_of(scripts_),
               precision_of(scene, options)),
        pair_cache_(capacities_of(scene).bodies, capacities_of(scene).pairs),
        pool_(static_cast<std::uint32_t>(options.helpers.size()) + 1, options.helpers),
        stirrer_(scene.stirrer),
        cubes_(static_cast<std::uint32_t>(scene.cubes.size())) {
    set_denormals_flush();
    if (pool_.threads() > 1) {
      world_.share_work(pool_.executor());
      pair_cache_.share_work(pool_.executor(), pool_.threads());
    }
    BodyId id = 0;
    const double friction = scene.friction;
    for (const Cube& cube : scene.cubes) {
      auto body = physics::make_dynamic_body(id++, shape_of(scene, cube), cube.mass_kg, friction,
                                             {cube.position, cube.rotation});
      body.inertia = inertia_of(scene, cube);
      insert(body);
    }
    for (std::uint32_t i = 0; i < scripts_.size(); ++i) add_rod(i, id++, friction);
    for (const Wall& wall : scene.walls)
      insert(physics::make_fixed_body(id++, physics::Shape::box(wall.half_extents_m), friction,
                                      {wall.position, wall.rotation}));
    if (terrain_)
      insert(physics::make_fixed_body(id++, physics::Shape::mesh(terrain_->mesh.half_extents, 0), friction,
                                      terrain_->given_from_body));
  }

  void step() override {
    const std::span<physics::Body> rods = world_.bodies().subspan(cubes_);
    for (std::size_t i = 0; i < rods.size(); ++i) {
      auto& motion = rods[i].motion;
      motion.velocity = stirrer_->velocity_over(i, motion.pose.position, time_s_, step_s_);
    }
    if (turning_) settings_.gravity = gravity_m_per_s2_ * turning_->direction(time_s_);
    world_.begin_step(settings_);
    const double start_us = times_broad_phase_ ? thread_time_us() : 0;
    const bool all = !is_global_ ? physics::find_pairs_brute_force(world_.bounds(), world_.dynamic_pairs())
                                 : pair_cache_.find(world_.bounds(), world_.dynamic_pairs());
    if (times_broad_phase_) broad_phase_us_ = thread_time_us() - start_us;
    if (!all) lost_ |= physics::kPairsFull;
    report_ = world_.finish_step(settings_);
    lost_ |= report_.capacity_bits;
    time_s_ += step_s_;
  }

  Measurement measure() override {
    Measurement m;
    m.contacts = report_.points;
    for (const auto& contact : world_.contacts()) {
      const auto points = std::span(contact.points).first(contact.count);
      m.touching_pairs += std::any_of(points.begin(), points.end(), [](const auto& p) { return p.separation <= 0.0; });
    }
    m.residual_speed_m_per_s = residual_speed(cubes());
    return m;
  }

  std::vector<CubeState> cubes() const override {
    std::vector<CubeState> states;
    states.reserve(cubes_);
    for (const auto& body : world_.bodies().first(cubes_)) {
      const Posed pose = body.motion.pose;
      states.push_back({.position = pose.position, .velocity = body.motion.velocity.linear, .rotation = pose.rotation});
    }
    return states;
  }

  std::vector<Posed> rods() const override {
    std::vector<Posed> poses;
    for (const auto& body : world_.bodies().subspan(cubes_)) poses.push_back(body.motion.pose);
    return poses;
  }

  std::string settings() const override {
    return fmt::format("{} precision, {} sub-steps, {} relax sweep, contacts {:g} Hz, damping ratio {:g}",
                       sim::name_of(world_.precision()), settings_.sub_steps, settings_.relax_sweeps,
                       settings_.contact_hertz, settings_.contact_damping_ratio);
  }

  double broad_phase_us() const override { return broad_phase_us_; }

  std::string failure() const override {
    if (lost_ == 0) return {};
    return fmt::format("work was left out: capacity bits {:#x} (1 bodies, 4 pairs, 8 contacts)", lost_);
  }

 private:
  void insert(const physics::Body& body) { TACTUS_CHECK(world_.insert(body), body.id, world_.bodies().size()); }

  // Its mass is not used: a kinematic body acts as infinitely heavy.
  void add_rod(std::size_t rod, BodyId id, double friction) {
    const Posed at = stirrer_->pose_at(rod, 0);
    insert(physics::make_dynamic_body(id, physics::Shape::box(stirrer_->half_extents_m), 1.0, friction,
                                      {at.position, {}}));
  }

  double step_s_;
  physics::StepSettings settings_;
  bool is_global_, times_broad_phase_;
  double broad_phase_us_{0};
  std::vector<physics::KinematicScript> scripts_;
  std::vector<physics::Hull> hulls_;
  double gravity_m_per_s2_;
  std::optional<TurningGravity> turning_;
  std::optional<sim::BuiltMesh> terrain_;
  std::vector<physics::Mesh> meshes_;
  physics::World world_;
  sim::PairCache pair_cache_;
  sim::WorkerPool pool_;
  std::optional<Stirrer> stirrer_;
  std::uint32_t cubes_;
  physics::StepReport report_;
  std::uint32_t lost_{0};  // CapacityBit
  double time_s_{0};
};

}  // namespace

std::unique_ptr<Engine> make_tactus(const BoxScene& scene, const EngineOptions& options) {
  return std::make_unique<TactusEngine>(scene, options);
}

}  // namespace tactus::experiment
