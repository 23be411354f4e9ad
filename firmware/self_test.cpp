#include "firmware/self_test.h"

namespace tactus::firmware {
namespace {

constexpr std::uint32_t kForbidsForce = static_cast<std::uint32_t>(SelfTestBit::kTables) |
                                        static_cast<std::uint32_t>(SelfTestBit::kConfiguration) |
                                        static_cast<std::uint32_t>(SelfTestBit::kWatchdog);

}  // namespace

bool is_watchdog_good(const Config& config) noexcept {
  bool good = watchdog_share(0, config) == 1.0f && watchdog_share(config.brake_frames, config) == 0.0f;
  const float fading = watchdog_share(config.fade_frames, config);
  good = good && fading > 0.0f && fading < 1.0f;
  for (unsigned s = 0; s < kStates; ++s)
    good = good && next_state(static_cast<State>(s), Event::kEmergencyStop) == State::kBrake;
  for (unsigned e = 0; e < kEvents; ++e) {
    const auto event = static_cast<Event>(e);
    if (event != Event::kRearm) good = good && next_state(State::kBrake, event) == State::kBrake;
  }
  return good && next_state(State::kForce, Event::kCommandsLost) == State::kBrake &&
         next_state(State::kBrake, Event::kRearm) == State::kIdle;
}

bool SelfTest::is_fault() const noexcept { return ((failed_ | found_) & kForbidsForce) != 0; }

void SelfTest::step(const ConfigView& accepted, const ConfigView& in_force, bool encoders_good,
                    bool motor_bus_good) noexcept {
  if (!encoders_good) note(SelfTestBit::kEncoders);
  if (!motor_bus_good) note(SelfTestBit::kMotorBus);
  if (row_ < table_.size()) {
    // Forces a read from memory instead of the compile-time constants.
    const Register* row = &table_[row_];
    asm volatile("" : "+r"(row) : : "memory");
    so_far_ = fingerprint(so_far_, *row);
    if (row->section != Section::kNone && !has_same_fields(*row, accepted, in_force)) note(SelfTestBit::kConfiguration);
    ++row_;
    return;
  }
  if (so_far_ != built_fingerprint()) note(SelfTestBit::kTables);
  if (!is_watchdog_good(*in_force.control)) note(SelfTestBit::kWatchdog);
  failed_ = found_;
  ++passes_;
  start();
}

}  // namespace tactus::firmware
