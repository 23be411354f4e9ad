#include "tools/session/world_rebuilder.h"

#include <fmt/format.h>

#include <cstring>

#include "rt/haptics/coupling/snapshot_bytes.h"

namespace tactus::session {

std::string why_not_rebuilt(const OpenTape& tape) {
  const RunOptions& options = tape.settings.options;
  if (!haptics::traits_of(options.coupling).global_world) return "the direct coupling has no world outside";
  if (options.hands > 1) return "the tape is of one hand, and the world outside was moved by others as well";
  if (!tape.settings.knows_world) return "an older tape, without the global world's precision";
  return tape.warning;
}

WorldRebuilder::WorldRebuilder(sim::GlobalWorld& world)
    : world_(world),
      next_(std::make_unique<haptics::WorldSnapshot>()),
      report_(std::make_unique<haptics::SubWorldReport>()),
      bytes_(haptics::snapshot_bytes_bound()) {}

Status WorldRebuilder::take_snapshot(const loop::TapeRecord& record) {
  if (snapshots_ == 0)
    world_.first_snapshot(*next_);
  else if (has_report_)
    world_.step(*report_, *next_);
  else
    return Status::error(fmt::format("the tape has no report before snapshot {}", snapshots_));
  has_report_ = false;
  ByteWriter own(bytes_);
  haptics::write_snapshot(own, *next_);
  if (own.size() != record.payload.size() || std::memcmp(bytes_.data(), record.payload.data(), own.size()) != 0)
    return Status::error(fmt::format("the rebuilt snapshot {} is not the taped one", snapshots_));
  ++snapshots_;
  return Status::good();
}

Status WorldRebuilder::adopted(const haptics::SubWorldReport& report, std::uint32_t member_budget) {
  if (member_budget == 0) return Status::error("an older tape, without what the governor allowed");
  *report_ = report;
  report_->member_budget = member_budget;
  has_report_ = true;
  return Status::good();
}

}  // namespace tactus::session
