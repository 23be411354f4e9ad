// The global side of the exchange: reads H(n) when it is available, steps the global world, publishes G(n+1).
//
// serve() never waits, so that a thread can poll it and a virtual clock can call it.
// Thread: the global world's, [setup] publish_first. Bound: no report or snapshot number is skipped; a late report
// causes a late snapshot, nothing else.
#pragma once

#include "rt/haptics/coupling/exchange.h"
#include "sim/global_world.h"

namespace tactus::sim {

class SnapshotServer {
 public:
  SnapshotServer(GlobalWorld& world, haptics::Exchange& exchange) noexcept : world_(world), exchange_(exchange) {}

  // G(0), before the first tick.
  void publish_first() noexcept {
    world_.first_snapshot(exchange_.snapshots.writing(0));
    exchange_.snapshots.publish(0);
  }

  // True if H(n) is available, n = next_report().
  bool has_report() const noexcept { return exchange_.reports.try_read(next_report_) != nullptr; }

  // Runs one cycle if its report is available. Returns whether it was.
  bool serve() noexcept {
    const haptics::SubWorldReport* report = exchange_.reports.try_read(next_report_);
    if (report == nullptr) return false;
    // G(n+1) may be written only now: it shares a buffer with G(n-1), which the haptic side released before H(n).
    world_.step(*report, exchange_.snapshots.writing(next_report_ + 1));
    exchange_.snapshots.publish(next_report_ + 1);
    ++next_report_;
    return true;
  }

  std::uint64_t next_report() const noexcept { return next_report_; }
  // [setup] The world and the exchange have been restored to where this report is the next.
  void continue_at(std::uint64_t next_report) noexcept { next_report_ = next_report; }

 private:
  GlobalWorld& world_;
  haptics::Exchange& exchange_;
  std::uint64_t next_report_{0};
};

}  // namespace tactus::sim
