// One period of the haptic thread in three stages that the caller may time: read the device, compute, write.
//
// Identical in real time and virtual time; only the caller differs. Thread: construction [setup]; the stages [rt], in
// order. Bound: the device's read and write by their contract; compute by the governor and the cut.
#pragma once

#include "rt/base/nonblocking.h"
#include "rt/haptics/coupling/exchange.h"
#include "rt/loop/flight_recorder.h"

namespace tactus::loop {

template <haptics::HapticDevice Device>
class HapticDriver {
 public:
  // `exchange`: null for the direct coupling. `recorder`: null if nothing is recorded.
  HapticDriver(HapticLoop& loop, Device& device, Governor& governor, haptics::Exchange* exchange,
               FlightRecorder* recorder) noexcept
      : loop_(loop), device_(device), governor_(governor), exchange_(exchange), recorder_(recorder) {}

  // read() and write() are bounded by the device's contract and may enter the kernel.
  void read() noexcept { device_.read(input_.device); }

  const TickOutput& compute(std::uint32_t operator_bits, const physics::CutPredicate& cut,
                            const StageObserver& stages = {}) noexcept TACTUS_NONBLOCKING {
    input_.operator_bits = operator_bits;
    input_.cut = cut;
    input_.stages = stages;
    poll_exchange();
    WorkCounts counts = loop_.counts();
    counts.synchronises = input_.snapshot != nullptr;
    counts.joins = input_.snapshot != nullptr ? input_.snapshot->joiners.size() : 0;
    plan_ = governor_.plan(counts);
    input_.sub_steps = plan_.sub_steps;
    if (recorder_ != nullptr) recorder_->before_tick(loop_);
    loop_.tick(input_, output_);
    return output_;
  }

  void write() noexcept {
    device_.write(output_.command);
    if (recorder_ != nullptr) recorder_->after_tick(input_, output_);
  }

  // After write(): for the tape, if there is one.
  void record_times(const TickTimesRecord& times) noexcept {
    if (recorder_ != nullptr) recorder_->times(times);
  }

  // The values of the last tick on which the next one depends. Contains no pointer.
  struct State {
    haptics::DeviceInput device;
    TickOutput output;
    TickPlan plan;
    std::uint32_t component{0};
    std::uint32_t member_budget{haptics::kMaxMembers};
  };
  State state() const noexcept {
    return {.device = input_.device,
            .output = output_,
            .plan = plan_,
            .component = component_,
            .member_budget = member_budget_};
  }
  // [setup] Between two ticks.
  void set_state(const State& state) noexcept {
    input_ = {};
    input_.device = state.device;
    output_ = state.output;
    plan_ = state.plan;
    component_ = state.component;
    member_budget_ = state.member_budget;
  }

  const TickOutput& output() const noexcept { return output_; }
  const haptics::DeviceSample& sample() const noexcept { return input_.device.sample; }  // newest sample
  const TickPlan& plan() const noexcept { return plan_; }
  // True if the governor's member budget was below the configured one at the last synchronisation.
  bool restrained() const noexcept { return member_budget_ < governor_.config().members; }
  std::uint32_t sub_steps() const noexcept { return plan_.sub_steps; }
  bool synchronised() const noexcept { return input_.snapshot != nullptr; }
  std::uint32_t component() const noexcept { return component_; }

 private:
  void poll_exchange() noexcept {
    input_.snapshot = nullptr;
    if (exchange_ == nullptr || !loop_.wants_snapshot()) return;
    const std::uint64_t cycle = loop_.next_cycle();
    input_.snapshot = exchange_->snapshots.try_read(cycle);
    if (input_.snapshot == nullptr) return;
    component_ = input_.snapshot->component;
    input_.sink = {&exchange_->reports.writing(cycle), &HapticDriver::publish, this};
  }

  static void publish(void* self, std::uint64_t cycle) noexcept {
    auto& driver = *static_cast<HapticDriver*>(self);
    driver.member_budget_ = driver.governor_.member_budget(driver.loop_.counts());
    driver.input_.sink.report->member_budget = driver.member_budget_;
    driver.exchange_->reports.publish(cycle);
  }

  HapticLoop& loop_;
  Device& device_;
  Governor& governor_;
  haptics::Exchange* exchange_;
  FlightRecorder* recorder_;
  TickInput input_;
  TickOutput output_;
  TickPlan plan_;
  std::uint32_t component_{0};
  std::uint32_t member_budget_{haptics::kMaxMembers};
};

}  // namespace tactus::loop
