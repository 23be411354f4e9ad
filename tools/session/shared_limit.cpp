#include "tools/session/shared_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>

#include "rt/base/denormals.h"
#include "rt/haptics/coupling/sub_world.h"
#include "rt/haptics/coupling_limits.h"
#include "tools/session/session.h"

namespace tactus::session {
namespace {

constexpr double kMeanSteps = 1.5;  // global steps from a sample to the other hand's sub-world, in the mean
constexpr double kArm_m = 0.02;     // from the body's centre to each proxy
// Mass of the body / mass of a proxy. The body is light, because with a heavier one the stability limit is higher.
constexpr double kShareOfProxy = 0.05;
// A push far below anything that could use up the border's tank; observed before and after half a second.
constexpr double kPush = 1e-6;  // m/s or rad/s
constexpr double kPush_s = 0.05, kEarly_s = 0.15, kLate_s = 0.75, kWindow_s = 0.3;
constexpr double kApart = 1.05;  // accuracy of the limit
constexpr double kLeastShare = 0.01;

bool turns(SharedAxis axis) { return axis == SharedAxis::kRotation; }

// The device's mass and damping where the scene has them: motion there is `motion_scale` times the device's.
haptics::AxisLimits axis_of(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device,
                            SharedAxis axis) {
  if (turns(axis)) return haptics::rotation_of(device, options.period_s(), options.late_s);
  haptics::AxisLimits limits = haptics::translation_of(device, options.period_s(), options.late_s);
  const double s2 = scene.device.motion_scale * scene.device.motion_scale;
  limits.mass /= s2;
  limits.damping /= s2;
  return limits;
}

double& stiffness_of(haptics::CouplingGains& gains, SharedAxis axis) {
  return turns(axis) ? gains.stiffness_Nm_per_rad : gains.stiffness_N_per_m;
}

// Two proxies like the scene's, and a light body between them that is jointed to both.
sim::Scene pair_of(const sim::Scene& scene, double stiffness, SharedAxis axis) {
  sim::Scene pair;
  pair.effects.friction = pair.effects.gyroscopic = pair.effects.joints = true;
  pair.gravity_m_per_s2 = {};
  pair.solver = scene.solver;
  pair.ratio = scene.ratio;
  pair.members = 3;
  pair.coupling = scene.coupling;
  stiffness_of(pair.coupling, axis) = stiffness;
  const physics::Body& proxy = scene.bodies[scene.proxy];
  const physics::Shape ball = physics::Shape::sphere(0.5 * kArm_m);
  for (BodyId id = 0; id < 2; ++id) {
    const double x_m = id == 0 ? -kArm_m : kArm_m;
    pair.bodies.push_back(physics::make_dynamic_body(id, ball, proxy.mass, 0, {{x_m, 0, 0}, {}}));
    pair.bodies.back().inertia = proxy.inertia;
    pair.bodies.back().gravity_scale = 0;
    pair.effect_data.joints.push_back(
        {.kind = physics::JointKind::kFixed, .a = 2, .b = id, .a_from_joint = {{x_m, 0, 0}, {}}, .b_from_joint = {}});
  }
  const physics::Shape box = physics::Shape::box({0.2 * kArm_m, 0.2 * kArm_m, 0.2 * kArm_m});
  pair.bodies.push_back(physics::make_dynamic_body(2, box, kShareOfProxy * proxy.mass, 0, {}));
  pair.proxy = 0;
  pair.more_hands.push_back({.proxy = 1, .device = {}, .coupling = pair.coupling, .hand = {}});
  return pair;
}

// A device that moves along or turns about x: mass and damping, a force held over the tick, and late by whole ticks.
class LateDevice {
 public:
  explicit LateDevice(const haptics::AxisLimits& axis)
      : axis_(axis), forces_(static_cast<std::size_t>(std::ceil(axis.delay_s / axis.period_s - 1e-9)), 0.0) {}

  haptics::DeviceTarget target(double start_m, bool turns) noexcept {
    const double velocity = (at_ - before_) / axis_.period_s;
    before_ = at_;
    haptics::DeviceTarget target;
    target.engaged = true;
    target.pose = {{start_m + (turns ? 0 : at_), 0, 0}, quat_from_rotation_vector(Vec3d{turns ? at_ : 0, 0, 0})};
    (turns ? target.velocity.angular : target.velocity.linear).x = velocity;
    return target;
  }
  void hold(double force) {
    forces_.push_back(force);
    const double now = forces_.front(), rate = axis_.damping / axis_.mass, T = axis_.period_s;
    forces_.pop_front();
    if (rate * T < 1e-9) {
      at_ += T * (velocity_ + 0.5 * T * now / axis_.mass);
      velocity_ += T * now / axis_.mass;
      return;
    }
    const double end = now / axis_.damping, left = std::exp(-rate * T);
    at_ += end * T + (velocity_ - end) * (1 - left) / rate;
    velocity_ = end + (velocity_ - end) * left;
  }
  void push(double velocity) noexcept { velocity_ += velocity; }
  double velocity() const noexcept { return velocity_; }

 private:
  haptics::AxisLimits axis_;
  std::deque<double> forces_;
  double at_{0}, before_{0}, velocity_{0};
};

struct PairHand {
  std::unique_ptr<haptics::SubWorld> world;
  std::unique_ptr<haptics::WorldSnapshot> snapshot = std::make_unique<haptics::WorldSnapshot>();
  std::unique_ptr<haptics::WorldSnapshot> next = std::make_unique<haptics::WorldSnapshot>();
  std::unique_ptr<haptics::SubWorldReport> report = std::make_unique<haptics::SubWorldReport>();
};

double limit_of(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device,
                SharedAxis axis) {
  haptics::CouplingGains asked = scene.coupling;
  const double wanted = stiffness_of(asked, axis) / haptics::kAllowedStiffnessShare;
  double least = shared_formula_limit(scene, options, device, axis), most = wanted;
  const auto good = [&](double stiffness) { return shared_body_rings_out(scene, options, device, axis, stiffness); };
  if (good(wanted)) return std::numeric_limits<double>::infinity();
  least = std::min(least, 0.5 * wanted);
  while (!good(least)) {
    most = least;
    least *= 0.5;
    if (least < kLeastShare * wanted) return 0;
  }
  while (most > kApart * least) {
    const double middle = std::sqrt(least * most);
    (good(middle) ? least : most) = middle;
  }
  return least;
}

}  // namespace

double shared_formula_limit(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device,
                            SharedAxis axis) {
  haptics::AxisLimits limits = axis_of(scene, options, device, axis);
  limits.delay_s += kMeanSteps * ratio_of(scene, options) * options.period_s();
  return haptics::uncoupled_stiffness_limit(
      limits, turns(axis) ? scene.coupling.damping_Nms_per_rad : scene.coupling.damping_Ns_per_m);
}

bool shared_body_rings_out(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device,
                           SharedAxis axis, double stiffness) {
  const bool turn = turns(axis);
  const sim::Scene first = pair_of(scene, stiffness, axis), second = sim::scene_of_hand(first, 1);
  const sim::Scene* const views[] = {&first, &second};
  RunOptions own = options;
  own.hands = 1;  // their gains are those of the trial
  own.ratio = ratio_of(scene, options);
  own.members = 0;
  sim::GlobalOptions global = global_options(first, own, device);
  global.more_devices = {{.proxy = 1,
                          .gains = global.gains,
                          .max_speed_m_per_s = global.reach.max_speed_m_per_s,
                          .max_angular_speed_rad_per_s = global.reach.max_angular_speed_rad_per_s}};
  sim::GlobalWorld world(first, global);
  std::array<PairHand, 2> hands;
  std::vector<LateDevice> devices(2, LateDevice(axis_of(scene, options, device, axis)));
  for (std::uint32_t d = 0; d < 2; ++d) {
    hands[d].world = std::make_unique<haptics::SubWorld>(loop_config(*views[d], own, device).sub_world,
                                                         std::span<const physics::Body>());
    world.first_snapshot(*hands[d].snapshot, d);
  }
  const unsigned sub_steps = hands[0].world->config().step.sub_steps;
  const double T = options.period_s();
  double early = 0, late = 0;
  const auto ticks = static_cast<std::uint64_t>((kLate_s + kWindow_s) / T);
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const double time_s = static_cast<double>(tick) * T;
    if (tick % own.ratio == 0) {
      for (PairHand& hand : hands) hand.world->synchronise(*hand.snapshot, *hand.report);
      const haptics::SubWorldReport* const reports[] = {hands[0].report.get(), hands[1].report.get()};
      haptics::WorldSnapshot* const next[] = {hands[0].next.get(), hands[1].next.get()};
      world.step(reports, next);
      for (PairHand& hand : hands) std::swap(hand.snapshot, hand.next);
    }
    if (tick == static_cast<std::uint64_t>(kPush_s / T)) devices[0].push(kPush);
    for (std::size_t d = 0; d < 2; ++d) {
      const haptics::DeviceTarget target = devices[d].target(d == 0 ? -kArm_m : kArm_m, turn);
      const Wrenchd wrench = hands[d].world->step(target, sub_steps, {}).on_device;
      devices[d].hold(turn ? wrench.torque.x : wrench.force.x);
    }
    const double speed = std::abs(devices[0].velocity() - devices[1].velocity());
    if (!(speed < 1)) return false;
    if (time_s >= kEarly_s && time_s < kEarly_s + kWindow_s) early = std::max(early, speed);
    if (time_s >= kLate_s) late = std::max(late, speed);
  }
  return late < early;
}

SharedLimits shared_limits(const sim::Scene& scene, const RunOptions& options,
                           const haptics::DeviceProperties& device) {
  const auto mode = float_mode();
  set_denormals_flush();
  SharedLimits limits;
  limits.stiffness_N_per_m = limit_of(scene, options, device, SharedAxis::kTranslation);
  if (device.has_rotation) limits.stiffness_Nm_per_rad = limit_of(scene, options, device, SharedAxis::kRotation);
  restore_float_mode(mode);
  return limits;
}

}  // namespace tactus::session
