#include "tools/hil/held_force.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "hal/device_words.h"
#include "tools/caught.h"

namespace tactus::hil {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

// Beyond the time that the force takes to come.
constexpr double kPatience_s = 2;

}  // namespace

HeldForce::HeldForce(DeviceUnderTest& under_test, const Vec3d& direction)
    : test_(under_test), direction_(direction), slope_N_(kSlope_N_per_s / under_test.options.rate_Hz) {
  if (test_.options.stepped) return;
  thread_ = std::thread([this] {
    loop::CpuAwake awake;
    (void)caught([&] { (void)loop::setup_realtime(test_.options.setup, awake); });
    auto deadline = std::chrono::steady_clock::now();
    const auto period = std::chrono::nanoseconds(std::llround(1e9 / test_.options.rate_Hz));
    while (!stop_.load(std::memory_order_relaxed)) {
      std::this_thread::sleep_until(deadline += period);
      tick();
    }
  });
}

HeldForce::~HeldForce() {
  (void)push(0);
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void HeldForce::tick() noexcept {
  test_.device.read(input_);
  state_.store(input_.sample.state, std::memory_order_relaxed);
  look();
  const bool well = trouble_.load(std::memory_order_relaxed) == Trouble::kNone;
  const double wanted_N = well ? wanted_N_.load(std::memory_order_relaxed) : 0;
  const bool pushes = wanted_N > 0 || (well && force_N_ > 0);
  const bool in_force = input_.sample.state == DeviceState::kForce;
  force_N_ = !well ? 0 : in_force ? std::clamp(wanted_N, force_N_ - slope_N_, force_N_ + slope_N_) : force_N_;
  command_.wanted = pushes ? DeviceState::kForce : DeviceState::kIdle;
  command_.wrench.force = direction_ * force_N_;
  ++command_.sequence;
  test_.device.write(command_);
  given_N_.store(force_N_, std::memory_order_release);
}

// Ends a push if the device has a fault, is silent or has moved too far.
void HeldForce::look() noexcept {
  missing_ = input_.status == ReadStatus::kFresh ? 0 : missing_ + 1;
  if (wanted_N_.load(std::memory_order_relaxed) <= 0 && force_N_ <= 0) {
    based_ = false;
    return;
  }
  if (trouble_.load(std::memory_order_relaxed) != Trouble::kNone) return;
  const haptics::DeviceSample& sample = input_.sample;
  if (sample.device_fault != 0 || sample.state == DeviceState::kBrake) {
    fault_.store(sample.device_fault, std::memory_order_relaxed);
    trouble_.store(Trouble::kFault, std::memory_order_release);
  } else if (missing_ > kMostMissing || input_.status == ReadStatus::kDisconnected) {
    trouble_.store(Trouble::kSilent, std::memory_order_release);
  } else if (input_.status == ReadStatus::kFresh) {
    if (!based_) base_ = sample.device_from_tool.position;
    based_ = true;
    const double moved_m = norm(sample.device_from_tool.position - base_);
    moved_m_.store(moved_m, std::memory_order_relaxed);
    if (moved_m > kMostMoved_m) trouble_.store(Trouble::kMoved, std::memory_order_release);
  }
}

bool HeldForce::is_there() const noexcept {
  return trouble_.load(std::memory_order_acquire) != Trouble::kNone ||
         given_N_.load(std::memory_order_acquire) == wanted_N_.load(std::memory_order_relaxed);
}

void HeldForce::pass(double seconds) {
  if (!test_.options.stepped) return std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  for (long i = std::lround(seconds * test_.options.rate_Hz); i > 0; --i) tick();
}

Status HeldForce::push(double force_N) {
  constexpr double kLook_s = 0.01;
  if (force_N > 0 && given_N_.load(std::memory_order_acquire) <= 0)
    trouble_.store(Trouble::kNone, std::memory_order_release);
  const double way_N = std::abs(force_N - given_N_.load(std::memory_order_acquire));
  wanted_N_.store(force_N, std::memory_order_release);
  double left_s = kPatience_s + way_N / kSlope_N_per_s;
  for (; !is_there() && left_s > 0; left_s -= kLook_s) pass(kLook_s);
  pass(kSettle_s);
  if (Status status = trouble(); !status.ok()) return status;
  return left_s > 0 ? Status::good()
                    : Status::error(fmt::format("the device gives no force: it is in {}",
                                                hal::name_of(state_.load(std::memory_order_relaxed))));
}

Status HeldForce::trouble() const {
  switch (trouble_.load(std::memory_order_acquire)) {
    case Trouble::kNone:
      return Status::good();
    case Trouble::kFault: {
      const std::string words = hal::describe_device_fault(fault_.load(std::memory_order_relaxed));
      return Status::error("the push ended: " + (words.empty() ? "the device braked" : words));
    }
    case Trouble::kSilent:
      return Status::error("the push ended: the device sends no samples");
    case Trouble::kMoved:
      return Status::error(fmt::format("the push ended: the grip moved by {:.0f} mm, so it does not rest on the scale",
                                       1e3 * moved_m_.load(std::memory_order_relaxed)));
  }
  return Status::good();
}

}  // namespace tactus::hil
