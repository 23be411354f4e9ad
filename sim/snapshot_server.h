// The global side of the exchange: reads H(n) when it is available, steps the global world, publishes G(n+1).
//
// With several devices there is one exchange for each, and one step for all of them: it begins when all reports have
// arrived. A device that does not report can be left out of the step (GlobalThread decides), so that the world
// continues for the others. serve() never waits, so that a thread can poll it and a virtual clock can call it.
// Thread: the global world's, [setup] publish_first. Bound: no report or snapshot number is skipped; a late report
// causes a late snapshot, nothing else.
#pragma once

#include <algorithm>
#include <vector>

#include "rt/haptics/coupling/exchange.h"
#include "sim/global_world.h"

namespace tactus::sim {

class SnapshotServer {
 public:
  SnapshotServer(GlobalWorld& world, haptics::Exchange& exchange) : SnapshotServer(world, std::vector{&exchange}) {}
  // One exchange for each of the world's devices, in their order.
  SnapshotServer(GlobalWorld& world, std::vector<haptics::Exchange*> exchanges)
      : world_(world),
        exchanges_(std::move(exchanges)),
        next_(exchanges_.size(), 0),
        left_out_(exchanges_.size(), 0),
        reports_(exchanges_.size(), nullptr),
        snapshots_(exchanges_.size(), nullptr) {
    TACTUS_CHECK(exchanges_.size() == world.devices(), exchanges_.size(), world.devices());
  }

  // G(0), before the first tick.
  void publish_first() noexcept {
    for (std::uint32_t d = 0; d < exchanges_.size(); ++d) world_.first_snapshot(exchanges_[d]->snapshots.writing(0), d);
    for (haptics::Exchange* exchange : exchanges_) exchange->snapshots.publish(0);
  }

  // True if serve() would run a cycle: H(n) of every device that is not left out is available, and of one at least.
  bool has_report() const noexcept {
    bool any = false;
    for (std::size_t d = 0; d < exchanges_.size(); ++d) {
      const bool there = has_report(d);
      if (!there && left_out_[d] == 0) return false;
      any = any || there;
    }
    return any;
  }
  // True if at least one report is available: its device waits for the step.
  bool is_waited_for() const noexcept {
    for (std::size_t d = 0; d < exchanges_.size(); ++d)
      if (has_report(d)) return true;
    return false;
  }
  // Excludes the devices without a report from the following steps, each until its next report is available.
  void leave_out_the_missing() noexcept {
    for (std::size_t d = 0; d < exchanges_.size(); ++d)
      if (!has_report(d)) left_out_[d] = 1;
  }

  // Runs one cycle if its reports are available. Returns whether they were.
  bool serve() noexcept {
    if (!has_report()) return false;
    for (std::size_t d = 0; d < exchanges_.size(); ++d) {
      reports_[d] = exchanges_[d]->reports.try_read(next_[d]);
      snapshots_[d] = nullptr;
      if (reports_[d] == nullptr) continue;
      // G(n+1) may be written only now: it shares a buffer with G(n-1), which the haptic side released before H(n).
      snapshots_[d] = &exchanges_[d]->snapshots.writing(next_[d] + 1);
      left_out_[d] = 0;
    }
    world_.step(reports_, snapshots_);
    for (std::size_t d = 0; d < exchanges_.size(); ++d)
      if (reports_[d] != nullptr) exchanges_[d]->snapshots.publish(++next_[d]);
    return true;
  }

  std::uint64_t next_report(std::size_t device = 0) const noexcept { return next_[device]; }
  // [setup] Call after the world and all exchanges have been restored: the next report of each device has this number.
  void continue_at(std::uint64_t next_report) noexcept {
    std::ranges::fill(next_, next_report);
    std::ranges::fill(left_out_, 0);
  }

 private:
  bool has_report(std::size_t d) const noexcept { return exchanges_[d]->reports.try_read(next_[d]) != nullptr; }

  // By device. next_: n, the number of its next report; left_out_: 1 while steps do not wait for its report; reports_,
  // snapshots_: of the cycle being served.
  GlobalWorld& world_;
  std::vector<haptics::Exchange*> exchanges_;
  std::vector<std::uint64_t> next_;
  std::vector<std::uint8_t> left_out_;
  std::vector<const haptics::SubWorldReport*> reports_;
  std::vector<haptics::WorldSnapshot*> snapshots_;
};

}  // namespace tactus::sim
