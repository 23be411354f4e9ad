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
#include "tools/experiment/timing.h"

namespace tactus::experiment {
namespace {

constexpr std::uint32_t kPairsPerBody = 16, kContactsPerBody = 8;  // as in the global world
// Where sizes differ, a large body has hundreds of small neighbours.
constexpr std::uint32_t kPairsPerMixedBody = 48, kContactsPerMixedBody = 16;
constexpr double kLongStep_s = 5e-3;
constexpr double kMostHertz = 250,
                 kHertzPerSubStep = 0.125;  // an octave below the accuracy limit: a heap comes to rest soon
// The rod: heavy beside a cube, on a spring that gives way by about a millimetre.
constexpr double kPaddleMass_kg = 20, kPaddleStiffness = 2e5, kPaddleDamping = 4e3;  // N/m, N s/m
constexpr double kPaddleTurnStiffness = 1e4, kPaddleTurnDamping = 2e2;               // N m/rad, N m s/rad

template <class T>
Vec3<T> as(const Vec3d& v) {
  return {static_cast<T>(v.x), static_cast<T>(v.y), static_cast<T>(v.z)};
}
template <class T>
Vec3d as_double(const Vec3<T>& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

bool is_mixed(const BoxScene& scene) {
  return std::any_of(scene.cubes.begin(), scene.cubes.end(),
                     [&](const Cube& cube) { return cube.edge_m != scene.cubes.front().edge_m; });
}

// Larger than a sub-world can be?
bool is_global(const BoxScene& scene) { return scene.cubes.size() + (scene.paddle ? 1 : 0) > haptics::kMaxMembers; }

physics::Capacities capacities_of(const BoxScene& scene) {
  const auto bodies = static_cast<std::uint32_t>(scene.cubes.size() + 1);
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

template <class T>
class TactusEngine final : public Engine {
 public:
  TactusEngine(const BoxScene& scene, const EngineOptions& options, Precision precision)
      : settings_(settings_of<T>(scene, options.sub_steps)),
        precision_(precision),
        is_global_(is_global(scene)),
        times_broad_phase_(options.time_broad_phase),
        world_(capacities_of(scene), {}, {}, {},
               precision_ == Precision::kMixed ? physics::SweepPrecision::kSingle : physics::SweepPrecision::kFull),
        pair_cache_(capacities_of(scene).bodies, capacities_of(scene).pairs),
        pool_(static_cast<std::uint32_t>(options.helpers.size()) + 1, options.helpers),
        paddle_(scene.paddle),
        cubes_(static_cast<std::uint32_t>(scene.cubes.size())) {
    set_denormals_flush();
    if (pool_.threads() > 1) {
      world_.share_work(pool_.executor());
      pair_cache_.share_work(pool_.executor(), pool_.threads());
    }
    BodyId id = 0;
    const T friction = static_cast<T>(scene.friction);
    for (const Cube& cube : scene.cubes) {
      const T half = static_cast<T>(0.5 * cube.edge_m);
      const Quat<T> rotation{static_cast<T>(cube.rotation.w), static_cast<T>(cube.rotation.x),
                             static_cast<T>(cube.rotation.y), static_cast<T>(cube.rotation.z)};
      insert(physics::make_dynamic_body<T>(id++, physics::Shape<T>::box({half, half, half}),
                                           static_cast<T>(cube.mass_kg), friction, {as<T>(cube.position), rotation}));
    }
    if (paddle_) add_paddle(id++, friction);
    for (const Wall& wall : scene.walls)
      insert(physics::make_fixed_body<T>(id++, physics::Shape<T>::box(as<T>(wall.half_extents_m)), friction,
                                         {as<T>(wall.position), {}}));
  }

  void step() override {
    if (paddle_) {
      auto& spring = world_.device_spring();
      spring.target.position = as<T>(paddle_->position_at(time_s_));
      spring.target_velocity.linear = as<T>(paddle_->velocity_at(time_s_));
    }
    world_.begin_step(settings_);
    const double start_us = times_broad_phase_ ? thread_time_us() : 0;
    const bool all = !is_global_ ? physics::find_pairs_brute_force(world_.bounds(), world_.dynamic_pairs())
                                 : pair_cache_.find(world_.bounds(), world_.dynamic_pairs());
    if (times_broad_phase_) broad_phase_us_ = thread_time_us() - start_us;
    if (!all) lost_ |= physics::kPairsFull;
    report_ = world_.finish_step(settings_);
    lost_ |= report_.capacity_bits;
    time_s_ += static_cast<double>(settings_.dt);
  }

  Measurement measure() override {
    Measurement m;
    m.contacts = report_.points;
    m.penetration_m = static_cast<double>(report_.deepest_m);
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
    for (const auto& body : world_.bodies().first(cubes_))
      states.push_back({as_double(body.motion.pose.position), as_double(body.motion.velocity.linear)});
    return states;
  }

  std::string settings() const override {
    return fmt::format("{} precision, {} sub-steps, {} relax sweep, contacts {:g} Hz, damping ratio {:g}",
                       precision_name(precision_), settings_.sub_steps, settings_.relax_sweeps,
                       static_cast<double>(settings_.contact_hertz),
                       static_cast<double>(settings_.contact_damping_ratio));
  }

  double broad_phase_us() const override { return broad_phase_us_; }

  std::string failure() const override {
    if (lost_ == 0) return {};
    return fmt::format("work was left out: capacity bits {:#x} (1 bodies, 4 pairs, 8 contacts)", lost_);
  }

 private:
  void insert(const physics::Body<T>& body) { TACTUS_CHECK(world_.insert(body), body.id, world_.bodies().size()); }

  void add_paddle(BodyId id, T friction) {
    auto rod =
        physics::make_dynamic_body<T>(id, physics::Shape<T>::box(as<T>(paddle_->half_extents_m)),
                                      static_cast<T>(kPaddleMass_kg), friction, {as<T>(paddle_->position_at(0)), {}});
    rod.gravity_scale = T(0);
    insert(rod);
    auto& spring = world_.device_spring();
    spring.enabled = true;
    spring.slot = static_cast<std::uint32_t>(world_.slot_of(id));
    spring.stiffness_N_per_m = static_cast<T>(kPaddleStiffness);
    spring.damping_Ns_per_m = static_cast<T>(kPaddleDamping);
    spring.stiffness_Nm_per_rad = static_cast<T>(kPaddleTurnStiffness);
    spring.damping_Nms_per_rad = static_cast<T>(kPaddleTurnDamping);
    spring.target = rod.motion.pose;
  }

  physics::StepSettings<T> settings_;
  Precision precision_;
  bool is_global_, times_broad_phase_;
  double broad_phase_us_{0};
  physics::World<T> world_;
  sim::PairCache pair_cache_;
  sim::WorkerPool pool_;
  std::optional<Paddle> paddle_;
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
