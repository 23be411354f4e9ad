// tactus itself: the world that both the haptic and the global side use, with the broad phase and the precision of the
// side whose size it has: up to the most that a sub-world holds those of the haptic side, beyond those of the global
// one.
#include <fmt/format.h>

#include <algorithm>

#include "rt/base/denormals.h"
#include "rt/haptics/snapshot.h"
#include "sim/pair_cache.h"
#include "sim/worker_pool.h"
#include "tools/experiment/engine.h"
#include "tools/experiment/scene_shapes.h"
#include "tools/experiment/timing.h"

namespace tactus::experiment {
namespace {

constexpr std::uint32_t kPairsPerBody = 16, kContactsPerBody = 8;  // as in the global world
// Where sizes differ, a large body has hundreds of small neighbours.
constexpr std::uint32_t kPairsPerMixedBody = 48, kContactsPerMixedBody = 16;
constexpr double kLongStep_s = 5e-3;
constexpr double kMostHertz = 250,
                 kHertzPerSubStep = 0.125;  // an octave below the accuracy limit: a heap comes to rest soon

template <class T>
Vec3<T> as(const Vec3d& v) {
  return {static_cast<T>(v.x), static_cast<T>(v.y), static_cast<T>(v.z)};
}
template <class T>
Quat<T> as(const Quatd& q) {
  return {static_cast<T>(q.w), static_cast<T>(q.x), static_cast<T>(q.y), static_cast<T>(q.z)};
}
template <class T>
physics::Shape<T> as(const physics::Shape<double>& s) {
  return {s.kind, s.index, static_cast<T>(s.radius), static_cast<T>(s.half_length), as<T>(s.half_extents)};
}
template <class T>
std::vector<physics::Hull<T>> hulls_of(const BoxScene& scene) {
  if constexpr (sizeof(T) == sizeof(double)) return scene.hulls;
  std::vector<physics::Hull<T>> hulls;
  if constexpr (sizeof(T) == sizeof(float))
    for (const auto& hull : scene.hulls) hulls.push_back(physics::narrowed(hull));
  return hulls;
}
template <class T>
Vec3d as_double(const Vec3<T>& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
template <class T>
Posed as_double(const Pose<T>& pose) {
  const Quat<T>& q = pose.rotation;
  return {as_double(pose.position), Quatd{static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y),
                                          static_cast<double>(q.z)}};
}

bool is_mixed(const BoxScene& scene) {
  return std::any_of(scene.cubes.begin(), scene.cubes.end(),
                     [&](const Cube& cube) { return cube.edge_m != scene.cubes.front().edge_m; });
}

// Larger than a sub-world can be?
bool is_global(const BoxScene& scene) { return scene.cubes.size() + rods_of(scene) > haptics::kMaxMembers; }

physics::Capacities capacities_of(const BoxScene& scene) {
  const auto bodies = static_cast<std::uint32_t>(scene.cubes.size()) + rods_of(scene) + 1;
  const bool mixed = is_mixed(scene);
  return {bodies, static_cast<std::uint32_t>(scene.walls.size()),
          (mixed ? kPairsPerMixedBody : kPairsPerBody) * bodies + 256,
          (mixed ? kContactsPerMixedBody : kContactsPerBody) * bodies + 256, 0};
}

template <class T>
physics::StepSettings<T> settings_of(const BoxScene& scene, unsigned sub_steps) {
  physics::StepSettings<T> settings;
  settings.dt = static_cast<T>(scene.step_s);
  settings.sub_steps = sub_steps > 0 ? sub_steps : scene.step_s > kLongStep_s ? 10 : 4;
  settings.contact_hertz = static_cast<T>(std::min(kMostHertz, kHertzPerSubStep * settings.sub_steps / scene.step_s));
  settings.gravity = {T(0), T(0), static_cast<T>(-scene.gravity_m_per_s2)};
  return settings;
}

// Rods follow the velocity that they are given before each step: scripts without way points.
std::vector<physics::KinematicScript> scripts_of(const BoxScene& scene) {
  std::vector<physics::KinematicScript> scripts;
  for (std::uint32_t i = 0; i < rods_of(scene); ++i)
    scripts.push_back({.id = static_cast<BodyId>(scene.cubes.size()) + i});
  return scripts;
}

template <class T>
physics::EffectSetups<T> effects_of(const std::vector<physics::KinematicScript>& scripts) {
  physics::EffectSetups<T> setups;
  std::get<typename physics::Kinematics<T>::Setup>(setups).scripts = scripts;
  return setups;
}

template <class T>
class TactusEngine final : public Engine {
 public:
  TactusEngine(const BoxScene& scene, const EngineOptions& options, Precision precision)
      : step_s_(scene.step_s),
        settings_(settings_of<T>(scene, options.sub_steps)),
        is_global_(is_global(scene)),
        times_broad_phase_(options.time_broad_phase),
        scripts_(scripts_of(scene)),
        hulls_(hulls_of<T>(scene)),
        world_(capacities_of(scene), hulls_, {}, effects_of<T>(scripts_),
               precision == Precision::kMixed ? physics::SweepPrecision::kSingle : physics::SweepPrecision::kFull),
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
    const T friction = static_cast<T>(scene.friction);
    for (const Cube& cube : scene.cubes) {
      auto body = physics::make_dynamic_body<T>(id++, as<T>(shape_of(scene, cube)), static_cast<T>(cube.mass_kg),
                                                friction, {as<T>(cube.position), as<T>(cube.rotation)});
      body.inertia = as<T>(inertia_of(scene, cube));
      insert(body);
    }
    for (std::uint32_t i = 0; i < scripts_.size(); ++i) add_rod(i, id++, friction);
    for (const Wall& wall : scene.walls)
      insert(physics::make_fixed_body<T>(id++, physics::Shape<T>::box(as<T>(wall.half_extents_m)), friction,
                                         {as<T>(wall.position), as<T>(wall.rotation)}));
  }

  void step() override {
    const std::span<physics::Body<T>> rods = world_.bodies().subspan(cubes_);
    for (std::size_t i = 0; i < rods.size(); ++i) {
      auto& motion = rods[i].motion;
      const Twistd v = stirrer_->velocity_over(i, as_double(motion.pose.position), time_s_, step_s_);
      motion.velocity = {as<T>(v.linear), as<T>(v.angular)};
    }
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
      m.touching_pairs += std::any_of(points.begin(), points.end(), [](const auto& p) { return p.separation <= T(0); });
    }
    m.residual_speed_m_per_s = residual_speed(cubes());
    return m;
  }

  std::vector<CubeState> cubes() const override {
    std::vector<CubeState> states;
    states.reserve(cubes_);
    for (const auto& body : world_.bodies().first(cubes_)) {
      const Posed pose = as_double(body.motion.pose);
      states.push_back({pose.position, as_double(body.motion.velocity.linear), pose.rotation});
    }
    return states;
  }

  std::vector<Posed> rods() const override {
    std::vector<Posed> poses;
    for (const auto& body : world_.bodies().subspan(cubes_)) poses.push_back(as_double(body.motion.pose));
    return poses;
  }

  std::string settings() const override {
    return fmt::format("{} precision, {} sub-steps, {} relax sweep, contacts {:g} Hz, damping ratio {:g}",
                       precision_name(precision()), settings_.sub_steps, settings_.relax_sweeps,
                       static_cast<double>(settings_.contact_hertz),
                       static_cast<double>(settings_.contact_damping_ratio));
  }

  // As its sweeps are: kinematic bodies need full precision.
  Precision precision() const noexcept {
    if (sizeof(T) == sizeof(float)) return Precision::kSingle;
    return world_.precision() == physics::SweepPrecision::kSingle ? Precision::kMixed : Precision::kDouble;
  }

  double broad_phase_us() const override { return broad_phase_us_; }

  std::string failure() const override {
    if (lost_ == 0) return {};
    return fmt::format("work was left out: capacity bits {:#x} (1 bodies, 4 pairs, 8 contacts)", lost_);
  }

 private:
  void insert(const physics::Body<T>& body) { TACTUS_CHECK(world_.insert(body), body.id, world_.bodies().size()); }

  // Its mass counts for nothing: to the others it is infinitely heavy.
  void add_rod(std::size_t rod, BodyId id, T friction) {
    const Posed at = stirrer_->pose_at(rod, 0);
    insert(physics::make_dynamic_body<T>(id, physics::Shape<T>::box(as<T>(stirrer_->half_extents_m)), T(1), friction,
                                         {as<T>(at.position), {}}));
  }

  double step_s_;
  physics::StepSettings<T> settings_;
  bool is_global_, times_broad_phase_;
  double broad_phase_us_{0};
  std::vector<physics::KinematicScript> scripts_;
  std::vector<physics::Hull<T>> hulls_;
  physics::World<T> world_;
  sim::PairCache pair_cache_;
  sim::WorkerPool pool_;
  std::optional<Stirrer> stirrer_;
  std::uint32_t cubes_;
  physics::StepReport<T> report_;
  std::uint32_t lost_{0};  // CapacityBit
  double time_s_{0};
};

}  // namespace

std::unique_ptr<Engine> make_tactus(const BoxScene& scene, const EngineOptions& options) {
  const Precision as_in_a_run = is_global(scene) ? Precision::kMixed : Precision::kDouble;
  const Precision precision = options.precision.value_or(as_in_a_run);
  if (precision == Precision::kSingle) return std::make_unique<TactusEngine<float>>(scene, options, precision);
  return std::make_unique<TactusEngine<double>>(scene, options, precision);
}

}  // namespace tactus::experiment
