#include "tactus/tape.h"

#include "tools/session/replay.h"

namespace tactus {

Error replay_tape(const std::filesystem::path& tape, Replay& replay, const std::function<void(double)>& progress) {
  const auto report = session::replay(tape.string(), progress);
  if (!report.ok()) return {Error::Kind::kFile, report.message()};
  const session::ReplayReport& r = report.value();
  replay = {.ticks = r.ticks,
            .compared = r.compared,
            .different = r.different,
            .lost_ticks = r.lost_ticks,
            .same_bits = r.same_bits(),
            .first_difference = r.first_difference,
            .damage = r.damage,
            .warning = r.warning};
  return {};
}

}  // namespace tactus
