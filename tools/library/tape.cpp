#include "tactus/tape.h"

#include "tools/session/replay.h"

namespace tactus {

Error replay_tape(const std::filesystem::path& tape, Replay& replay, const std::function<void(double)>& progress) {
  const auto report = session::replay(tape.string(), progress);
  if (!report.ok()) return {Error::Kind::kFile, report.message()};
  const session::ReplayReport& r = report.value();
  replay = {r.ticks, r.compared, r.different, r.lost_ticks, r.same_bits(), r.first_difference, r.damage, r.warning};
  return {};
}

}  // namespace tactus
