// The global side of the exchange: takes H(n) when it is there, steps the global world, publishes G(n+1).
//
// One function that never waits, so that a thread can poll it and a virtual clock can call it. Thread: the global
// world's, [setup] publish_first. Bound: nobody skips a number; a late report makes a late snapshot, nothing else.
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

  // Is H(n) there, n being next_report()?
  bool has_report() const noexcept { return exchange_.reports.try_read(next_report_) != nullptr; }

  // Does one cycle when its report is there; says whether it was.
  bool serve() noexcept {
    const haptics::SubWorldReport* report = exchange_.reports.try_read(next_report_);
    if (report == nullptr) return false;
    // Only now may G(n+1) be written: it shares a buffer with G(n-1), which the haptic side had left before H(n).
    world_.step(*report, exchange_.snapshots.writing(next_report_ + 1));
    exchange_.snapshots.publish(next_report_ + 1);
    ++next_report_;
    return true;
  }

  std::uint64_t next_report() const noexcept { return next_report_; }

 private:
  GlobalWorld& world_;
  haptics::Exchange& exchange_;
  std::uint64_t next_report_{0};
};

}  // namespace tactus::sim
