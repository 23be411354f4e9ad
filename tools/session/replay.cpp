#include "tools/session/replay.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <vector>

#include "rt/base/denormals.h"
#include "rt/haptics/coupling/snapshot_bytes.h"
#include "rt/tape/tape.h"
#include "sim/loader/scene_load.h"
#include "tools/session/session.h"

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
  return "the books (energies, counts, target)";
}

constexpr std::uint32_t kKinds[] = {loop::kKeyframeRecord, loop::kSnapshotRecord, loop::kTickRecord, loop::kTapeGap};

bool fire_at(void* sweep, std::uint32_t now) noexcept { return now >= *static_cast<const std::uint32_t*>(sweep); }

class Replayer {
 public:
  Replayer(std::unique_ptr<loop::HapticLoop> loop, ReplayReport& report)
      : loop_(std::move(loop)),
        report_(report),
        keyframe_(loop_->save_size_bound()),
        snapshot_(std::make_unique<haptics::WorldSnapshot>()),
        sink_(std::make_unique<haptics::SubWorldReport>()) {}

  Status take(const loop::TapeRecord& record) {
    switch (record.kind) {
      case loop::kKeyframeRecord:
        return take_keyframe(record);
      case loop::kSnapshotRecord:
        return take_snapshot(record);
      case loop::kTickRecord:
        return take_tick(record);
      case loop::kTapeGap:
        ++report_.gaps;
        in_step_ = false;
        has_snapshot_ = false;
        return Status::good();
      default:
        return bad(record, fmt::format("is of unknown kind {}", record.kind));
    }
  }

  // Records are missing from here on; the replay continues at the next keyframe.
  void take_damage(const std::string& what, std::uint64_t lost_bytes) {
    if (report_.damages++ == 0) report_.damage = what;
    report_.lost_bytes += lost_bytes;
    in_step_ = false;
    has_snapshot_ = false;
    damaged_ = true;
  }

  std::uint64_t state_hash() const { return loop_->state_hash(); }

 private:
  static Status bad(const loop::TapeRecord& record, const std::string& what) {
    return Status::error(fmt::format("record {} at byte {} {}; accepted: a tape that this program wrote", record.index,
                                     record.offset, what));
  }

  // Without a preceding gap, the keyframe must equal the replay's own state. After a gap, the replay continues from it.
  Status take_keyframe(const loop::TapeRecord& record) {
    ++report_.keyframes;
    if (in_step_) {
      ByteWriter own(keyframe_);
      loop_->save(own);
      const bool same =
          own.size() == record.payload.size() && std::memcmp(keyframe_.data(), record.payload.data(), own.size()) == 0;
      if (!same) ++report_.keyframes_different;
    }
    ByteReader in(record.payload);
    if (!loop_->restore(in) || in.remaining() != 0) return bad(record, "is no keyframe of this scene");
    in_step_ = true;
    return Status::good();
  }

  Status take_snapshot(const loop::TapeRecord& record) {
    ++report_.snapshots;
    ByteReader in(record.payload);
    const haptics::SubWorldConfig& config = loop_->sub_world().config();
    if (!haptics::read_snapshot(in, *snapshot_, config.hulls.size(), config.meshes) || in.remaining() != 0)
      return bad(record, "is no snapshot");
    has_snapshot_ = true;
    return Status::good();
  }

  Status take_tick(const loop::TapeRecord& record) {
    ++report_.ticks;
    TickRecord taped;
    if (record.payload.size() != sizeof(TickRecord)) return bad(record, "is no tick");
    std::memcpy(&taped, record.payload.data(), sizeof taped);
    if (damaged_ && taped.out.tick > next_tick_) report_.lost_ticks += taped.out.tick - next_tick_;
    next_tick_ = taped.out.tick + 1;
    damaged_ = false;
    const bool adopts = taped.adopts != 0;
    if (taped.sub_steps == 0 || taped.sub_steps > 1000) return bad(record, "has an impossible number of sub-steps");
    if (!in_step_ || (adopts && !has_snapshot_)) {
      in_step_ = false;
      ++report_.unreplayable;
      return Status::good();
    }
    loop::TickInput in;
    in.device = taped.device;
    in.operator_bits = taped.operator_bits;
    in.sub_steps = taped.sub_steps;
    if (adopts) {
      in.snapshot = snapshot_.get();
      in.sink.report = sink_.get();
    }
    std::uint32_t cut_at = taped.out.cut_sweep;
    if (cut_at != physics::kNeverCut) in.cut = {&fire_at, &cut_at};
    TickOutput out;
    loop_->tick(in, out);
    has_snapshot_ = false;
    compare(taped.out, out);
    return Status::good();
  }

  void compare(const TickOutput& taped, const TickOutput& replayed) {
    ++report_.compared;
    if (same_bits(taped, replayed)) return;
    if (report_.different++ > 0) return;
    report_.first_different_tick = taped.tick;
    report_.first_difference = describe_difference(taped, replayed);
  }

  std::unique_ptr<loop::HapticLoop> loop_;
  ReplayReport& report_;
  std::vector<std::byte> keyframe_;
  std::unique_ptr<haptics::WorldSnapshot> snapshot_;
  std::unique_ptr<haptics::SubWorldReport> sink_;
  bool in_step_{false}, has_snapshot_{false}, damaged_{false};
  std::uint64_t next_tick_{0};
};

}  // namespace

Result<ReplayReport> replay(const std::string& path, const std::function<void(double)>& progress) {
  set_denormals_flush();
  auto opened = loop::TapeReader::open(path);
  if (!opened.ok()) return opened.status();
  loop::TapeReader& tape = *opened.value();
  const auto prefixed = [&](const std::string& what) { return Status::error(path + ": " + what); };
  auto settings = from_tape_text(tape.text());
  if (!settings.ok()) return prefixed(settings.message());
  auto scene = sim::parse_scene(settings.value().scene_source, settings.value().scene_name);
  if (!scene.ok()) return prefixed("the scene on the tape: " + scene.message());
  // Checks everything that the loop is built from, as for a run.
  auto session = Session::create(std::move(scene).value(), settings.value().options);
  if (!session.ok()) return prefixed(session.message());

  ReplayReport report;
  report.scene_name = settings.value().scene_name;
  report.scene_file = settings.value().scene_file;
  report.scene_hash = settings.value().scene_hash;
  report.made_by = settings.value().made_by;
  if (tape.isa_tag() != loop::tape_isa_tag())
    report.warning = fmt::format("the tape was made with {}, this program is {}: bits may differ", tape.isa_tag(),
                                 loop::tape_isa_tag());
  Replayer replayer(std::move(session.value()->loop), report);
  std::error_code ignored;
  const auto size = static_cast<double>(std::filesystem::file_size(path, ignored));
  loop::TapeRecord record;
  for (loop::TapeRead read; (read = tape.next(record)) != loop::TapeRead::kEnd;) {
    if (read == loop::TapeRead::kDamaged) {
      const std::string what = tape.damage().message();
      replayer.take_damage(what, tape.skip_damage(kKinds));
      continue;
    }
    if (const Status status = replayer.take(record); !status.ok()) return prefixed(status.message());
    if (progress && record.index % 1024 == 0) progress(static_cast<double>(record.offset) / size);
  }
  report.state_hash = replayer.state_hash();
  return report;
}

}  // namespace tactus::session
