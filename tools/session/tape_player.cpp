#include "tools/session/tape_player.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>

#include "rt/haptics/coupling/snapshot_bytes.h"
#include "sim/loader/scene_load.h"

namespace tactus::session {
namespace {

constexpr std::uint32_t kKinds[] = {loop::kKeyframeRecord, loop::kSnapshotRecord, loop::kTickRecord, loop::kTimesRecord,
                                    loop::kTapeGap};
constexpr std::uint32_t kMaxSubSteps = 1000;

Status prefixed(const OpenTape& tape, const std::string& what) { return Status::error(tape.path + ": " + what); }

bool fire_at(void* sweep, std::uint32_t now) noexcept { return now >= *static_cast<const std::uint32_t*>(sweep); }

}  // namespace

Result<OpenTape> open_tape(const std::string& path) {
  auto reader = loop::TapeReader::open(path);
  if (!reader.ok()) return reader.status();
  OpenTape tape{.path = path, .reader = std::move(reader).value(), .settings = {}, .warning = {}};
  auto settings = from_tape_text(tape.reader->text());
  if (!settings.ok()) return prefixed(tape, settings.message());
  tape.settings = std::move(settings).value();
  if (tape.reader->isa_tag() != loop::tape_isa_tag())
    tape.warning = fmt::format("the tape was made with {}, this program is {}: bits may differ", tape.reader->isa_tag(),
                               loop::tape_isa_tag());
  return tape;
}

Result<std::unique_ptr<Session>> session_of(const OpenTape& tape) {
  auto scene = sim::parse_scene(tape.settings.scene_source, tape.settings.scene_name);
  if (!scene.ok()) return prefixed(tape, "the scene on the tape: " + scene.message());
  const RunOptions& options = tape.settings.options;
  const unsigned hands = scene.value().hands();
  if (options.hands != hands)
    return prefixed(tape, fmt::format("is of one of {} hands, and its scene has {}", options.hands, hands));
  // Checks everything that the loop is built from, as for a run. The world outside of several hands is not in one tape.
  auto session = hands == 1 ? Session::create(std::move(scene).value(), options)
                            : Session::create_hand(sim::scene_of_hand(std::move(scene).value(), options.hand), options);
  if (!session.ok()) return prefixed(tape, session.message());
  return session;
}

bool next_record(OpenTape& tape, loop::TapeRecord& record, const OnDamage& damage) {
  for (loop::TapeRead read; (read = tape.reader->next(record)) != loop::TapeRead::kEnd;) {
    if (read == loop::TapeRead::kRecord) return true;
    const std::string what = tape.reader->damage().message();
    const std::uint64_t lost_bytes = tape.reader->skip_damage(kKinds);
    if (damage) damage(what, lost_bytes);
  }
  return false;
}

Status walk(OpenTape& tape, const TapeVisitor& visitor) {
  constexpr std::uint64_t kRecordsBetweenProgress = 1024;
  std::error_code ignored;
  const auto size = static_cast<double>(std::filesystem::file_size(tape.path, ignored));
  for (loop::TapeRecord record; next_record(tape, record, visitor.damage);) {
    if (const Status status = visitor.record(record); !status.ok()) return prefixed(tape, status.message());
    if (visitor.progress && record.index % kRecordsBetweenProgress == 0)
      visitor.progress(static_cast<double>(record.offset) / size);
  }
  return Status::good();
}

Status bad_record(const loop::TapeRecord& record, const std::string& what) {
  return Status::error(fmt::format("record {} at byte {} {}; accepted: a tape that this program wrote", record.index,
                                   record.offset, what));
}

Result<loop::TickRecord> tick_of(const loop::TapeRecord& record) {
  loop::TickRecord taped;
  if (record.payload.size() != sizeof taped) return bad_record(record, "is no tick");
  std::memcpy(&taped, record.payload.data(), sizeof taped);
  if (taped.sub_steps == 0 || taped.sub_steps > kMaxSubSteps)
    return bad_record(record, "has an impossible number of sub-steps");
  return taped;
}

Result<loop::TickTimesRecord> times_of(const loop::TapeRecord& record) {
  loop::TickTimesRecord times;
  if (record.payload.size() != sizeof times) return bad_record(record, "has no times");
  std::memcpy(&times, record.payload.data(), sizeof times);
  return times;
}

TapePlayer::TapePlayer(std::unique_ptr<loop::HapticLoop> loop)
    : loop_(std::move(loop)),
      keyframe_(loop_->save_size_bound()),
      snapshot_(std::make_unique<haptics::WorldSnapshot>()),
      sink_(std::make_unique<haptics::SubWorldReport>()) {}

Status TapePlayer::take_keyframe(const loop::TapeRecord& record, bool& same) {
  same = true;
  if (in_step_) {
    ByteWriter own(keyframe_);
    loop_->save(own);
    same = own.size() == record.payload.size() && std::memcmp(keyframe_.data(), record.payload.data(), own.size()) == 0;
  }
  ByteReader in(record.payload);
  if (!loop_->restore(in) || in.remaining() != 0) return bad_record(record, "is no keyframe of this scene");
  in_step_ = true;
  return Status::good();
}

Status TapePlayer::take_snapshot(const loop::TapeRecord& record) {
  ByteReader in(record.payload);
  if (!haptics::read_snapshot(in, *snapshot_, loop_->sub_world().config().shapes) || in.remaining() != 0)
    return bad_record(record, "is no snapshot");
  has_snapshot_ = true;
  return Status::good();
}

bool TapePlayer::play(const loop::TickRecord& taped, loop::TickOutput& out) {
  const bool adopts = taped.adopts != 0;
  if (!in_step_ || (adopts && !has_snapshot_)) {
    in_step_ = false;
    return false;
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
  loop_->tick(in, out);
  has_snapshot_ = false;
  return true;
}

}  // namespace tactus::session
