// A hostile device on a link: whatever bytes it sends, the loop's commands must stay within the limits.
//
// A script of bytes is played through LinkedDevice and HapticLoop (direct coupling to a proxy that does not move, so
// that every accepted motion makes a force). Each tick begins with a byte that says what the link does, as bits:
//   1 sealed: a state frame with a right check, near the last one: at most 32 counts on from it
//   2 of a sealed one: counts from the script, whole 32 bits     4 of a sealed one: sequence and time from the script
//   8 nothing comes   16 the device is away   32, 64 the person arms, re-arms   128 of a sealed one: state and fault
// Without 1 the next byte is the length of what comes, and the bytes follow. A script that ends is zeros.
// Links with tactus_hal and tactus_rt_loop. Thread: one; nothing of it is real time but what it calls.
#pragma once

#include <cstring>
#include <utility>

#include "hal/linked_device.h"
#include "rt/loop/haptic_loop.h"

namespace tactus::test {

class ScriptReader {
 public:
  explicit ScriptReader(std::span<const std::uint8_t> script) : left_(script) {}
  bool empty() const { return left_.empty(); }
  std::uint8_t byte() {
    if (left_.empty()) return 0;
    const std::uint8_t first = left_.front();
    left_ = left_.subspan(1);
    return first;
  }
  std::uint32_t word() {
    std::uint32_t w = 0;
    for (unsigned i = 0; i < 4; ++i) w |= std::uint32_t{byte()} << (8 * i);
    return w;
  }

 private:
  std::span<const std::uint8_t> left_;
};

// A link that returns what the script says and stores commands in `sent`.
struct HostileLink {
  std::array<std::byte, firmware::kMaxFrameSize> bytes{};
  hal::ReceivedFrame next;
  bool plugged{true};
  std::array<std::byte, firmware::kMaxFrameSize> sent{};
  std::size_t sent_size{0};

  hal::ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    std::copy(bytes.begin(), bytes.end(), buffer.begin());
    return std::exchange(next, {});
  }
  bool send(std::span<const std::byte> frame) noexcept {
    sent_size = std::min(frame.size(), sent.size());
    std::copy_n(frame.begin(), sent_size, sent.begin());
    return true;
  }
  bool connected() const noexcept { return plugged; }
  hal::LinkCounters counters() const noexcept { return {}; }
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds) {
    return request;
  }
};

struct Hostilities {
  const char* violated{nullptr};  // the first limit that did not hold
  std::uint64_t ticks{0}, fresh{0}, corrupt{0}, faults{0};
  double most_force_N{0}, most_torque_Nm{0};  // commanded
};

class HostileSession {
 public:
  HostileSession(const hal::DeviceProfile& profile, std::span<const std::uint8_t> script)
      : profile_(profile), script_(script), device_(profile, 1'000'000, link_), loop_(config_of(profile), {}) {
    const auto proxy = physics::make_dynamic_body(0, physics::Shape::sphere(0.5), 1e9, 0.5, Posed{});
    loop_.set_members({&proxy, 1});
    frame_.state = firmware::State::kIdle;
  }

  // Runs `ticks` ticks, or fewer if the script ends or a limit is violated.
  Hostilities run(std::uint64_t ticks) {
    while (found_.violated == nullptr && found_.ticks < ticks && !script_.empty()) tick();
    found_.fresh = device_.counters().fresh;
    found_.corrupt = device_.counters().corrupt;
    return found_;
  }

 private:
  static loop::LoopConfig config_of(const hal::DeviceProfile& profile) {
    loop::LoopConfig config;
    config.device = profile.properties;
    config.placement.has_rotation = profile.properties.has_rotation;
    config.sub_world.scheme = haptics::CouplingScheme::kDirect;
    config.sub_world.proxy = 0;
    config.sub_world.step.dt = config.period_s;
    config.sub_world.capacities = {.bodies = 2, .fixed_bodies = 1, .pairs = 4, .contacts = 4, .border_contacts = 1};
    config.emergency_stop_fault = static_cast<std::uint32_t>(firmware::Fault::kEmergencyStop);
    return config;
  }

  void tick() {
    const std::uint8_t what = script_.byte();
    link_.plugged = (what & 16u) == 0;
    if ((what & 8u) == 0) arrive(what);
    in_.operator_bits = ((what & 32u) != 0 ? loop::kArm : 0u) | ((what & 64u) != 0 ? loop::kRearm : 0u);
    const Fault before = out_.fault;
    device_.read(in_.device);
    loop_.tick(in_, out_);
    device_.write(out_.command);
    ++found_.ticks;
    found_.faults += out_.fault != before && out_.fault != Fault::kNone ? 1 : 0;
    judge();
  }

  void arrive(std::uint8_t what) {
    if ((what & 1u) == 0) {
      link_.next = {script_.byte(), 1, 0};
      for (std::size_t i = 0; i < link_.next.size; ++i) {
        const auto b = static_cast<std::byte>(script_.byte());
        if (i < link_.bytes.size()) link_.bytes[i] = b;
      }
      return;
    }
    ++frame_.sequence;
    frame_.time_us += 1000;
    if ((what & 4u) != 0) {
      frame_.sequence = script_.word();
      frame_.time_us = script_.word();
    }
    for (std::int32_t& count : frame_.counts) {
      const int step = static_cast<std::int8_t>(script_.byte()) / 4;
      count = (what & 2u) != 0 ? static_cast<std::int32_t>(script_.word()) : firmware::count_difference(count, step);
    }
    if ((what & 128u) != 0) {
      frame_.state = static_cast<firmware::State>(script_.byte() & 3u);
      frame_.fault = script_.byte();
      frame_.limits = script_.byte();
    } else {  // does as it is told
      frame_.state = static_cast<firmware::State>(out_.command.wanted);
      frame_.fault = 0;
      frame_.limits = 0;
    }
    firmware::encode_state(frame_, std::span(link_.bytes).first<firmware::kStateFrameSize>());
    link_.next = {firmware::kStateFrameSize, 1, 0};
  }

  void judge() {
    const haptics::DeviceProperties& p = profile_.properties;
    const Wrenchd& wrench = out_.command.wrench;
    const double force = norm(wrench.force), torque = norm(wrench.torque);
    found_.most_force_N = std::max(found_.most_force_N, force);
    found_.most_torque_Nm = std::max(found_.most_torque_Nm, torque);
    if (!(force <= p.max_force_N)) found_.violated = "commanded force";  // NaN as well
    if (!(torque <= p.max_torque_Nm)) found_.violated = "commanded torque";
    ticks_in_fault_ = out_.fault != Fault::kNone ? ticks_in_fault_ + 1 : 0;
    if (ticks_in_fault_ > haptics::kFadeOutTicks && !(force == 0.0 && torque == 0.0))
      found_.violated = "force under a fault that had time to fade";
    firmware::CommandFrame command;
    if (firmware::decode_command(std::span(link_.sent).first(link_.sent_size), command) !=
        firmware::DecodeError::kNone) {
      found_.violated = "command frame";
      return;
    }
    // Whatever coordinates the device claims, no lever is longer than the stretched arm.
    const hal::ArmLinks& links = profile_.description.links;
    const double most = 1.001 * ((links.upper_m + links.forearm_m) * p.max_force_N + p.max_torque_Nm);
    for (const float effort : command.effort)
      if (!(std::abs(static_cast<double>(effort)) <= most)) found_.violated = "effort of an axis";
  }

  const hal::DeviceProfile& profile_;
  ScriptReader script_;
  HostileLink link_;
  hal::LinkedDevice<HostileLink> device_;
  loop::HapticLoop loop_;
  loop::TickInput in_;
  loop::TickOutput out_;
  firmware::StateFrame frame_;
  std::uint32_t ticks_in_fault_{0};
  Hostilities found_;
};

}  // namespace tactus::test
