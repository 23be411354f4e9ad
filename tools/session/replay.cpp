#include "tools/session/replay.h"

#include <fmt/format.h>

#include <cstring>

#include "rt/base/denormals.h"
#include "tools/session/tape_player.h"

namespace tactus::session {
namespace {

using loop::TickOutput;
using loop::TickRecord;

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

// Describes the first field that differs. Equality itself is decided by the bytes of the whole.
std::string describe_difference(const TickOutput& taped, const TickOutput& replayed) {
  const auto number = [](const char* name, double a, double b) {
    return fmt::format("{}: tape {:.17g}, replay {:.17g}", name, a, b);
  };
  const auto vector = [&](const char* name, const Vec3d& a, const Vec3d& b) {
    return fmt::format("{}: tape ({:.17g}, {:.17g}, {:.17g}), replay ({:.17g}, {:.17g}, {:.17g})", name, a.x, a.y, a.z,
                       b.x, b.y, b.z);
  };
  const TickOutput &t = taped, &r = replayed;
  if (t.fault != r.fault) return number("fault", static_cast<double>(t.fault), static_cast<double>(r.fault));
  if (t.members != r.members) return number("members", t.members, r.members);
  if (t.contacts != r.contacts) return number("contacts", t.contacts, r.contacts);
  if (t.points != r.points) return number("points", t.points, r.points);
  if (!same_bits(t.proxy.pose.position, r.proxy.pose.position))
    return vector("proxy position [m]", t.proxy.pose.position, r.proxy.pose.position);
  if (!same_bits(t.command.wrench.force, r.command.wrench.force))
    return vector("force [N]", t.command.wrench.force, r.command.wrench.force);
  if (!same_bits(t.command.wrench.torque, r.command.wrench.torque))
    return vector("torque [N m]", t.command.wrench.torque, r.command.wrench.torque);
  if (t.status != r.status) return number("status bits", t.status, r.status);
  if (t.cut_sweep != r.cut_sweep) return number("cut sweep", t.cut_sweep, r.cut_sweep);
  return "energies, counts and the device's target";
}

class Replayer {
 public:
  Replayer(std::unique_ptr<loop::HapticLoop> loop, ReplayReport& report) : player_(std::move(loop)), report_(report) {}

  Status take(const loop::TapeRecord& record) {
    switch (record.kind) {
      case loop::kKeyframeRecord:
        return take_keyframe(record);
      case loop::kSnapshotRecord:
        ++report_.snapshots;
        return player_.take_snapshot(record);
      case loop::kTickRecord:
        return take_tick(record);
      case loop::kTimesRecord:
        return Status::good();  // measured: no result depends on it
      case loop::kTapeGap:
        ++report_.gaps;
        player_.lose_step();
        return Status::good();
      default:
        return bad_record(record, fmt::format("is of unknown kind {}", record.kind));
    }
  }

  // Records are missing from here on; the replay continues at the next keyframe.
  void take_damage(const std::string& what, std::uint64_t lost_bytes) {
    if (report_.damages++ == 0) report_.damage = what;
    report_.lost_bytes += lost_bytes;
    player_.lose_step();
    damaged_ = true;
  }

  std::uint64_t state_hash() const { return player_.loop().state_hash(); }

 private:
  // Without a preceding gap, the keyframe must equal the replay's own state.
  Status take_keyframe(const loop::TapeRecord& record) {
    ++report_.keyframes;
    bool same = true;
    const Status status = player_.take_keyframe(record, same);
    if (!same) ++report_.keyframes_different;
    return status;
  }

  Status take_tick(const loop::TapeRecord& record) {
    ++report_.ticks;
    const auto read = tick_of(record);
    if (!read.ok()) return read.status();
    const TickRecord& taped = read.value();
    if (damaged_ && taped.out.tick > next_tick_) report_.lost_ticks += taped.out.tick - next_tick_;
    next_tick_ = taped.out.tick + 1;
    damaged_ = false;
    TickOutput out;
    if (player_.play(taped, out))
      compare(taped.out, out);
    else
      ++report_.unreplayable;
    return Status::good();
  }

  void compare(const TickOutput& taped, const TickOutput& replayed) {
    ++report_.compared;
    if (same_bits(taped, replayed)) return;
    if (report_.different++ > 0) return;
    report_.first_different_tick = taped.tick;
    report_.first_difference = describe_difference(taped, replayed);
  }

  TapePlayer player_;
  ReplayReport& report_;
  bool damaged_{false};
  std::uint64_t next_tick_{0};
};

}  // namespace

Result<ReplayReport> replay(const std::string& path, const std::function<void(double)>& progress) {
  set_denormals_flush();
  auto opened = open_tape(path);
  if (!opened.ok()) return opened.status();
  OpenTape& tape = opened.value();
  auto session = session_of(tape);
  if (!session.ok()) return session.status();

  ReplayReport report;
  report.scene_name = tape.settings.scene_name;
  report.scene_file = tape.settings.scene_file;
  report.scene_hash = tape.settings.scene_hash;
  report.made_by = tape.settings.made_by;
  report.warning = tape.warning;
  Replayer replayer(std::move(session.value()->loop), report);
  const Status walked =
      walk(tape, {.record = [&](const loop::TapeRecord& record) { return replayer.take(record); },
                  .damage = [&](const std::string& what, std::uint64_t lost) { replayer.take_damage(what, lost); },
                  .progress = progress});
  if (!walked.ok()) return walked;
  report.state_hash = replayer.state_hash();
  return report;
}

}  // namespace tactus::session
