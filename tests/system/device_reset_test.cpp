// A device whose program restarts in mid-run, for no period or a few: whenever that is, its force comes back by the
// ramp and never as a step.
#include <deque>
#include <vector>

#include "firmware/can_codec.h"
#include "hal/loopback_link.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;
// Share of a motor's limit by which an effort may rise in a period: the ramp of 0.2 s, and the hand's motion.
constexpr double kMaxRise = 0.01;
constexpr int kPatience = 40, kBack = 350;  // ticks from a reset to the re-arm, and from there until all force is back

enum class Wire { kUsb, kUsbLate, kClassicCan };

// The link of host and device: whole frames, whole frames with late commands, or fragments on classic CAN.
class ResetLink {
 public:
  ResetLink(const hal::DeviceProfile& profile, const hal::HandModel& hand, Wire wire)
      : device_(profile, hand, kPeriod_ns), wire_(wire) {}

  // The device's program starts again, after so many periods without one.
  void restart(unsigned periods) {
    device_.set_powered(false);
    splitter_ = {};
    commands_ = {};
    off_ = periods;
    if (off_ == 0) device_.set_powered(true);
  }
  const hal::LoopbackLink& device() const { return device_; }

  hal::ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    const bool was_off = off_ > 0;
    if (under_way_.size() > (wire_ == Wire::kUsbLate ? 2u : 0u)) {
      if (!was_off) (void)device_.send(under_way_.front());
      under_way_.pop_front();
    }
    hal::ReceivedFrame frame = device_.receive(buffer);
    if (was_off && --off_ == 0) device_.set_powered(true);
    if (wire_ != Wire::kClassicCan) return frame;
    states_.look();
    firmware::StateFrame state;
    if (frame.size == 0 || firmware::decode_state(whole(buffer), state) != firmware::DecodeError::kNone) return {};
    std::array<firmware::CanFragment, firmware::kStateFragments + 1> fragments{};
    const unsigned count = splitter_.split(state, fragments);
    bool complete = false;
    for (unsigned i = 0; i < count; ++i) complete |= states_.accept(fragments[i].function, fragments[i].data, state);
    if (!complete) return {};
    firmware::encode_state(state, whole(buffer));
    return frame;
  }

  bool send(std::span<const std::byte> bytes) noexcept {
    firmware::CommandFrame command;
    if (wire_ == Wire::kClassicCan) {
      REQUIRE(firmware::decode_command(bytes, command) == firmware::DecodeError::kNone);
      states_.sent(command.sequence);
      if (off_ > 0) return true;
      bool complete = false;
      for (const firmware::CanFragment& f : firmware::split_command(command))
        complete |= commands_.accept(f.function, f.data, command);
      if (!complete) return true;
      std::array<std::byte, firmware::kCommandFrameSize> joined{};
      firmware::encode_command(command, joined);
      under_way_.emplace_back(joined.begin(), joined.end());
    } else {
      under_way_.emplace_back(bytes.begin(), bytes.end());
    }
    return true;
  }

  bool connected() const noexcept { return true; }
  hal::LinkCounters counters() const noexcept { return device_.counters(); }
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds timeout) {
    return device_.call(request, timeout);
  }

 private:
  static std::span<std::byte, firmware::kStateFrameSize> whole(std::span<std::byte, firmware::kMaxFrameSize> buffer) {
    return buffer.first<firmware::kStateFrameSize>();
  }

  hal::LoopbackLink device_;
  Wire wire_;
  std::deque<std::vector<std::byte>> under_way_;
  unsigned off_{0};
  firmware::StateSplitter splitter_;
  firmware::StateAssembler states_{1000};
  firmware::CommandAssembler commands_;
};

// A hand that goes down steadily, from just above the block of kPressScene, in the device's frame: wherever the device
// is coupled again, its force rises.
hal::HandModel pressing_hand(double speed_m_per_s) {
  constexpr double kWhole_s = 5;
  hal::HandParameters parameters;
  parameters.motion = haptics::HandMotion::kLinear;
  const std::vector<hal::HandWaypoint> path = {{0.0, {0, 0, -0.008}, {}},
                                               {kWhole_s, {0, 0, -0.008 - kWhole_s * speed_m_per_s}, {}}};
  return hal::HandModel(parameters, path);
}

struct ResetRun {
  ResetLink* link{nullptr};
  std::unique_ptr<session::Session> session;
  std::unique_ptr<session::VirtualRun> run;
  firmware::AxisValues before{};
  double largest{0}, rise{0};  // of the efforts, and of their rise in one period: in shares of the motors' limits

  ResetRun(Wire wire, double speed_m_per_s) {
    const hal::DeviceProfile& profile = *hal::find_profile("virtuose6d");
    auto any = std::make_unique<hal::AnyLink>(std::make_unique<ResetLink>(profile, pressing_hand(speed_m_per_s), wire));
    link = any->as<ResetLink>();
    session::Hardware hardware;
    using Device = hal::DeviceOnLink<hal::AnyLink>;
    hardware.device = std::make_unique<hal::AnyDevice>(std::make_unique<Device>(profile, kPeriod_ns, std::move(any)));
    hardware.identity = "a link in this process";
    session::RunOptions options;
    options.device = "usb";
    options.priority = 0;
    auto made = session::Session::create(scene_text(kPressScene), options, std::move(hardware));
    INFO(made.message());
    REQUIRE(made.ok());
    session = std::move(made).value();
    run = std::make_unique<session::VirtualRun>(*session);
  }

  void ticks(int count, std::uint32_t first_bits = 0) {
    for (int i = 0; i < count; ++i) tick(i == 0 ? first_bits : 0);
  }
  void tick(std::uint32_t bits = 0) {
    run->tick(bits);
    const firmware::AxisValues& now = link->device().motor_outputs().effort;
    const firmware::AxisValues& limit = link->device().device().config().control.max_effort;
    for (unsigned i = 0; i < firmware::kAxes; ++i) {
      const double share = static_cast<double>(std::abs(now[i]) / limit[i]);
      largest = std::max(largest, share);
      rise = std::max(rise, share - static_cast<double>(std::abs(before[i]) / limit[i]));
    }
    before = now;
  }
  Fault fault() const { return run_output().fault; }
  const loop::TickOutput& run_output() const { return session->driver->output(); }
  bool presses() const { return largest > 2 * kMaxRise; }
};

}  // namespace

TEST_CASE("after a device reset at any tick of a run the force returns without a step, and the run reports why") {
  const auto wire = GENERATE(Wire::kUsb, Wire::kUsbLate, Wire::kClassicCan);
  const auto speed_m_per_s = GENERATE(0.03, 0.06);
  const auto periods = GENERATE(0u, 1u, 2u);
  CAPTURE(static_cast<int>(wire), speed_m_per_s, periods);
  ResetRun r(wire, speed_m_per_s);
  r.ticks(500);
  REQUIRE(r.fault() == Fault::kNone);
  REQUIRE(r.presses());
  for (int reset = 0; reset < 6; ++reset) {
    CAPTURE(reset);
    r.link->restart(periods);
    r.rise = 0;
    r.ticks(kPatience);
    CHECK(r.rise <= 1e-4);  // none at all before somebody asks for it
    CHECK(r.fault() == Fault::kDeviceLeftForce);
    r.largest = 0;
    // Some are reset again while the force comes in, some when it is back.
    r.ticks(kBack - 40 * reset, loop::kRearm);
    REQUIRE(r.fault() == Fault::kNone);
    CHECK(r.presses());
    CHECK(r.rise <= kMaxRise);
  }
}

TEST_CASE("a device that is reset while a run begins gives no step either") {
  const auto wire = GENERATE(Wire::kUsb, Wire::kUsbLate, Wire::kClassicCan);
  for (int at = 0; at < 60; ++at) {
    ResetRun r(wire, 0.06);
    r.ticks(at);
    r.link->restart(static_cast<unsigned>(at) % 2);
    r.ticks(200);
    if (r.fault() != Fault::kNone) r.ticks(kBack, loop::kRearm);
    r.ticks(kBack);
    CAPTURE(static_cast<int>(wire), at);
    CHECK(r.fault() == Fault::kNone);
    CHECK(r.presses());
    CHECK(r.rise <= kMaxRise);
  }
}
