#include "tools/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "firmware/faults.h"
#include "hal/device_class.h"
#include "sim/exchange/sub_world_config.h"
#include "sim/loader/body_label.h"
#include "sim/loader/scene_load.h"
#include "sim/model/choice_names.h"
#include "sim/model/step_settings.h"
#include "tools/session/arm_gate.h"
#include "tools/session/find_description.h"
#include "tools/session/scheme_gains.h"
#include "tools/session/shared_limit.h"

namespace tactus::session {
namespace {

// One keyframe per second at 1 kHz, and a ring large enough for a disk that stalls for a few seconds.
constexpr std::uint32_t kKeyframeTicks = 1000;
constexpr std::uint64_t kRingBytes = 16u << 20;
constexpr std::size_t kHistoryBytes = 64u << 20;
// --rearm clears a fault this long after it latched.
constexpr double kRearmAfter_s = 1.0;

std::uint32_t dynamic_bodies_of(const sim::Scene& scene) {
  return static_cast<std::uint32_t>(scene.bodies.size() - sim::fixed_bodies_of(scene).size());
}

unsigned members_of(const sim::Scene& scene, const RunOptions& options) {
  if (!traits_of(options.coupling).global_world) return dynamic_bodies_of(scene);
  if (traits_of(options.coupling).proxy_alone()) return 1;
  if (options.all_members) return std::min(dynamic_bodies_of(scene), haptics::kMaxMembers);
  if (options.members != 0) return options.members;
  if (options.accuracy == Accuracy::kFast) return std::max(1u, scene.members / 2);
  return options.accuracy == Accuracy::kAccurate ? std::min(2 * scene.members, haptics::kMaxMembers) : scene.members;
}

// Of the haptic side.
unsigned sub_steps_of(const sim::Scene& scene, const RunOptions& options) {
  const unsigned written = scene.solver.sub_steps;
  if (options.accuracy == Accuracy::kFast)
    return std::min(written,
                    std::max(written / 2, sim::least_sub_steps(scene.solver.contact_hertz, options.period_s())));
  return options.accuracy == Accuracy::kAccurate ? 2 * written : written;
}

haptics::DevicePlacement::Config placement_of(const sim::Scene& scene, const haptics::DeviceProperties& device) {
  return {scene.device.world_from_device, scene.device.motion_scale, device.has_rotation};
}

// One contact frequency in both worlds, and both worlds must resolve it: at most a quarter of the sub-step rate.
Status check_frequency(const sim::Scene& scene, const RunOptions& options) {
  const double haptic_Hz = 0.25 * scene.solver.sub_steps * options.rate_Hz;
  const double global_Hz =
      !traits_of(options.coupling).global_world ? haptic_Hz : sim::max_contact_hertz(scene.solver, options.period_s());
  const double limit_Hz = std::min(haptic_Hz, global_Hz);
  if (scene.solver.contact_hertz <= limit_Hz * (1 + 1e-9)) return Status::good();
  return Status::error(fmt::format(
      "{}: contact frequency {:g} Hz is not resolved at --rate {:g} Hz; accepted: up to {:g} Hz (a quarter of the "
      "slower world's sub-steps per second)",
      scene.name, scene.solver.contact_hertz, options.rate_Hz, limit_Hz));
}

}  // namespace

unsigned ratio_of(const sim::Scene& scene, const RunOptions& options) {
  if (!traits_of(options.coupling).global_world) return 1;
  return options.ratio != 0 ? options.ratio : scene.ratio;
}

// Transforms the scene's hand path from the world to the device frame.
hal::HandModel make_hand(const sim::Scene& scene) {
  const sim::HandScript& script = scene.hand;
  const Posed device_from_world = inverse(scene.device.world_from_device);
  std::vector<hal::HandWaypoint> path;
  for (const sim::ScriptWaypoint& waypoint : script.path) {
    const Quatd rotation = device_from_world.rotation * quat_from_rotation_vector(waypoint.rotation_vector_rad);
    const Vec3d velocity = rotate(device_from_world.rotation, waypoint.velocity_m_per_s);
    path.push_back(
        {.time_s = waypoint.time_s,
         .position_m = (device_from_world * waypoint.position_m) * (1.0 / scene.device.motion_scale),
         .rotation_vector_rad = hal::rotation_vector_of(rotation),
         .velocity_m_per_s = velocity * (1.0 / scene.device.motion_scale),
         .angular_velocity_rad_per_s = rotate(device_from_world.rotation, waypoint.angular_velocity_rad_per_s)});
  }
  hal::HandParameters parameters;
  parameters.stiffness_N_per_m = script.stiffness_N_per_m;
  parameters.damping_Ns_per_m = script.damping_Ns_per_m;
  parameters.mass_kg = script.mass_kg;
  parameters.stiffness_Nm_per_rad = script.stiffness_Nm_per_rad;
  parameters.damping_Nms_per_rad = script.damping_Nms_per_rad;
  parameters.repeat = script.repeat;
  parameters.motion = script.motion;
  return hal::HandModel(parameters, path);
}

sim::GlobalOptions global_options(const sim::Scene& scene, const RunOptions& options,
                                  const haptics::DeviceProperties& device) {
  sim::GlobalOptions global;
  global.coupling = options.coupling;
  global.border_mode = options.border;
  global.precision = sim::sweep_precision(scene, options.world_precision);
  global.gains = gains_of(scene, options, device).gains;
  global.haptic_sub_steps = sub_steps_of(scene, options);
  global.extraction.cap = members_of(scene, options);
  global.extraction.order = options.order;
  global.extraction.all_members = options.all_members;
  global.reach.reach = options.reach;
  global.reach.ratio = ratio_of(scene, options);
  global.reach.tick_period_s = options.period_s();
  global.reach.max_speed_m_per_s = device.max_speed_m_per_s * scene.device.motion_scale;
  global.reach.max_angular_speed_rad_per_s = device.max_angular_speed_rad_per_s;
  return global;
}

loop::LoopConfig loop_config(const sim::Scene& scene, const RunOptions& options,
                             const haptics::DeviceProperties& device) {
  loop::LoopConfig config;
  config.period_s = options.period_s();
  config.device = device;
  config.placement = placement_of(scene, device);
  config.thinnest_m = physics::thinnest(scene.bodies);
  config.emergency_stop_fault = static_cast<std::uint32_t>(firmware::Fault::kEmergencyStop);
  config.sub_world = sim::sub_world_config(scene, {.coupling = options.coupling,
                                                   .border = options.border,
                                                   .proxy = scene.proxy,
                                                   .ratio = ratio_of(scene, options),
                                                   .tick_period_s = options.period_s(),
                                                   .sub_steps = sub_steps_of(scene, options),
                                                   .members = members_of(scene, options),
                                                   .gains = gains_of(scene, options, device).gains});
  return config;
}

std::unique_ptr<loop::HapticLoop> make_loop(const sim::Scene& scene, const RunOptions& options,
                                            const haptics::DeviceProperties& device) {
  const auto fixed = sim::fixed_bodies_of(scene);
  auto loop = std::make_unique<loop::HapticLoop>(loop_config(scene, options, device), fixed);
  if (!traits_of(options.coupling).global_world) loop->set_members(scene.bodies);
  return loop;
}

Result<std::unique_ptr<Session>> Session::create(sim::Scene scene, RunOptions options, Hardware hardware) {
  if (scene.hands() > 1)
    return Status::error(fmt::format("{}: has {} hands ([[proxy]]); accepted: one here, several with tactus run",
                                     scene.name, scene.hands()));
  auto session = create_hand(std::move(scene), std::move(options), std::move(hardware));
  if (!session.ok()) return session;
  Session* const only = session.value().get();
  if (const Status status = share_world({&only, 1}); !status.ok()) return status;
  return session;
}

Result<std::unique_ptr<Session>> Session::create_hand(sim::Scene scene_in, RunOptions options_in, Hardware hardware) {
  std::unique_ptr<Session> session(new Session());
  session->scene = std::move(scene_in);
  session->options = std::move(options_in);
  const sim::Scene& scene = session->scene;
  session->options.hands = session->scene.hands();
  const RunOptions& options = session->options;
  session->ratio = ratio_of(scene, options);
  session->members = members_of(scene, options);

  auto script = split_inject_script(options.inject);
  if (!script.ok()) return script.status();
  session->stalls = script.value().stalls;
  session->resets = script.value().resets;
  if (!session->resets.empty() && !traits_of(options.coupling).global_world)
    return Status::error("--inject: reset: the direct coupling has no global world to reset");
  auto faults = hal::parse_fault_script(script.value().device);
  if (!faults.ok())
    return Status::error("--inject: " + faults.message() +
                         "; of the world stall@TICK+TICKS; of the operator reset@TICK");
  const bool simulated = hardware.device == nullptr;
  if (simulated) {
    const auto profile = find_description(scene.device.profile, options.device_file);
    if (!profile.ok())
      return options.device_file.empty() ? Status::error(fmt::format("{}: {}", scene.name, profile.message()))
                                         : profile.status();
    auto device = make_simulated(options, profile.value(), make_hand(scene), faults.value());
    if (!device.ok()) return device.status();
    hardware.device = std::move(device).value();
  }
  session->device = std::move(hardware.device);
  session->hand_ = session->device->as<hal::SimulatedDevice>();
  if (hardware.real || session->device->link_report().has_value()) session->arm_tick_ = kIdleTicks;
  session->device_identity = std::move(hardware.identity);
  session->same_device = std::move(hardware.same_device);
  session->gpio = std::move(hardware.gpio);
  const haptics::DeviceProperties& device = session->device->properties();
  if (options.hands > 1) {
    if (!haptics::traits_of(options.coupling).border)
      return Status::error(fmt::format("--coupling {}: is for one hand, and {} has {}; accepted: sub-world",
                                       sim::name_of(options.coupling), scene.name, options.hands));
    if (!options.taped_device) session->options.shared_limits = shared_limits(scene, options, device);
  }
  if (const Status status = check_gains(scene, options, device); !status.ok()) return status;
  if (const Status status = check_frequency(scene, options); !status.ok()) return status;

  session->loop = make_loop(scene, options, device);
  loop::GovernorConfig governor;
  governor.period_ns = options.period_s() * 1e9;
  governor.sub_steps = session->loop->config().sub_world.step.sub_steps;
  governor.min_sub_steps =
      std::min(governor.sub_steps, sim::least_sub_steps(scene.solver.contact_hertz, options.period_s()));
  governor.members = session->members;
  governor.min_members = std::min(governor.min_members, governor.members);
  session->governor = std::make_unique<loop::Governor>(governor);

  session->make_driver();
  return session;
}

void Session::make_driver() {
  driver = std::make_unique<Driver>(*loop, *device, *governor, exchange.get(), recorder.get());
}

Status Session::share_world(std::span<Session* const> hands) {
  Session& first = *hands.front();
  if (!traits_of(first.options.coupling).global_world) return Status::good();
  sim::GlobalOptions global = global_options(first.scene, first.options, first.device->properties());
  for (const Session* other : hands.subspan(1)) {
    const sim::GlobalOptions own = global_options(other->scene, other->options, other->device->properties());
    global.more_devices.push_back({.proxy = other->scene.proxy,
                                   .gains = own.gains,
                                   .max_speed_m_per_s = own.reach.max_speed_m_per_s,
                                   .max_angular_speed_rad_per_s = own.reach.max_angular_speed_rad_per_s});
  }
  if (const Status status = sim::check_global_options(first.scene, global); !status.ok()) return status;
  const auto world = std::make_shared<sim::GlobalWorld>(first.scene, global);
  const std::span<const int> cpus = first.options.world_cpus;  // the first is that of the global world's own thread
  const auto pool =
      std::make_shared<sim::WorkerPool>(first.options.world_threads, cpus.empty() ? cpus : cpus.subspan(1));
  world->share_work(*pool);
  const auto resets = hands.size() > 1 ? std::make_shared<std::atomic<std::uint32_t>>(0) : nullptr;
  for (Session* hand : hands) {
    hand->resets_of_all = resets;
    hand->global = world;
    hand->workers = pool;
    hand->exchange = std::make_unique<haptics::Exchange>();
    hand->make_driver();
  }
  return Status::good();
}

Status Session::record(const std::string& tape_path) {
  std::unique_ptr<loop::TapeWriter> tape;
  if (!tape_path.empty()) {
    auto created = loop::TapeWriter::create(tape_path, tape_text());
    if (!created.ok()) return created.status();
    tape = std::move(created).value();
  }
  recorder = std::make_unique<loop::FlightRecorder>(*loop, kRingBytes, kKeyframeTicks);
  loop::DrainSettings settings;
  settings.history_bytes = kHistoryBytes;
  settings.keyframe_kind = loop::kKeyframeRecord;
  settings.tick_kind = loop::kTickRecord;
  settings.tap = shown.tap;
  settings.tap_only_kind = loop::kBodiesRecord;
  if (global == nullptr && shown.watchers != nullptr) recorder->show_bodies(*shown.watchers);
  drain = std::make_unique<loop::TapeDrain>(recorder->ring(), settings, std::move(tape));
  make_driver();
  return Status::good();
}

void Session::close_tape(RunSummary& summary) {
  if (drain == nullptr) return;
  const Status status = drain->stop();
  const loop::TapeDrain::Counts counts = drain->counts();
  summary.tape = options.record.string();
  summary.tape_bytes = counts.bytes;
  summary.tape_dropped = counts.lost;
  summary.tape_lost_ticks = counts.ticks_not_written;
  summary.tape_fault = status.message();
}

void Session::count_tick() noexcept {
  const loop::TickOutput& out = driver->output();
  const std::uint32_t ended = driver->synchronised() ? progress_.cycle_ticks : 0;
  if (driver->synchronised()) {
    progress_.cycle_ticks = 0;
    if (driver->restrained()) ++stats.restrained_cycles;
  }
  ++progress_.cycle_ticks;
  stats.add(out, driver->sub_steps(), driver->component(), ended, ratio, driver->sample());
  progress_.latched_ticks = out.fault != Fault::kNone ? progress_.latched_ticks + 1 : 0;
  start_hand(out);
}

// After a reset the hand's path restarts at the point where the first trial had its force, so that all trials are
// equal.
void Session::start_hand(const loop::TickOutput& out) noexcept {
  const bool engaged = (out.status & (kNotArmed | kSceneReset)) == 0;
  if (engaged && !progress_.first_engaged && options.arm_at_start) progress_.first_engaged = out.tick;
  if (!progress_.hand_returns || (out.status & kSceneReset) != 0) return;
  progress_.hand_returns = false;
  hand_->start_path(static_cast<double>(progress_.first_engaged.value_or(0)) * options.period_s());
}

std::uint32_t Session::hold_for_hand(std::uint32_t bits) noexcept {
  if (hand_ == nullptr || global == nullptr) return 0;
  if ((bits & loop::kReset) != 0 && !progress_.hand_returns) {
    progress_.hand_returns = true;
    hand_->return_hand();
  }
  return progress_.hand_returns && !hand_->hand_is_back() ? loop::kHoldReset : 0u;
}

// A request that comes from all hands at once is one: while a reset is in progress, the loop takes no other.
std::uint32_t Session::share_reset(std::uint32_t bits) noexcept {
  if (resets_of_all == nullptr) return 0;
  constexpr auto relaxed = std::memory_order_relaxed;
  if ((bits & loop::kReset) != 0) {
    progress_.resets_seen = resets_of_all->fetch_add(1, relaxed) + 1;
    return 0;
  }
  const std::uint32_t asked = resets_of_all->load(relaxed);
  if (asked == progress_.resets_seen) return 0;
  progress_.resets_seen = asked;
  return loop::kReset;
}

std::uint32_t Session::operator_bits(std::uint32_t asked) noexcept {
  if (hand_ != nullptr) hand_input.apply(*hand_, scene.device.world_from_device, scene.device.motion_scale);
  std::uint32_t bits = asked | (stats.ticks == arm_tick_ && options.arm_at_start ? loop::kArm : 0u);
  for (; progress_.next_reset < resets.size() && resets[progress_.next_reset] <= stats.ticks; ++progress_.next_reset)
    bits |= loop::kReset;
  bits |= share_reset(bits);
  if (options.rearm && progress_.latched_ticks >= kRearmAfter_s * options.rate_Hz) {
    progress_.latched_ticks = 0;
    bits |= loop::kRearm;
  }
  return bits | hold_for_hand(bits);
}

bool Session::rest_hand() noexcept {
  if (hand_ == nullptr) return false;
  hand_->hold_hand();
  return true;
}

std::string overlapped_of(const sim::Scene& scene, const physics::Overlap& overlap) {
  if (overlap.a == kNoBody || overlap.b == kNoBody) return {};
  return fmt::format("{} and {}", sim::body_label(scene, overlap.a), sim::body_label(scene, overlap.b));
}

std::string Session::tape_text() const { return to_tape_text(options, device->properties(), scene.name, scene.source); }

bool Session::hand_is_scripted() const {
  if (options.taped_device || options.given_device) return false;
  const auto choice = hal::choose_device(options.device);
  return choice.ok() && choice.value().device_class->hand_by_script;
}

RunSummary Session::summary() const {
  RunSummary summary;
  summary.options = options;
  summary.scene_name = scene.name;
  summary.scene_title = scene.title;
  summary.scene_hash = sim::source_hash(scene.source);
  summary.ratio = ratio;
  summary.gains = gains_of(scene, options, device->properties());
  summary.members_cap = members;
  summary.sub_steps = loop->config().sub_world.step.sub_steps;
  summary.bodies = dynamic_bodies_of(scene);
  summary.scene_problems = sim::report_on(scene, device->properties(), options.period_s(), hand_is_scripted()).problems;
  summary.stats = stats;
  summary.has_global = global != nullptr;
  if (global != nullptr) summary.global = global->statistics();
  summary.overlapped = overlapped_of(scene, summary.global.overlap);
  if (const hal::SimulatedDevice* truth = simulated()) {
    summary.hand_work_J = truth->plant().work().hand;
    summary.motor_work_J = truth->plant().work().motors;
  }
  summary.device_identity = device_identity;
  summary.link = device->link_report();
  summary.state_hash = loop->state_hash();
  return summary;
}

}  // namespace tactus::session
