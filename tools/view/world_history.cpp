#include "tools/view/world_history.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "rt/base/denormals.h"
#include "tools/caught.h"
#include "tools/publication/packed.h"

namespace tactus::view {
namespace {

using publication::Position;
using publication::Rotation;

constexpr std::size_t kBytesOfBody = sizeof(Position) + sizeof(Rotation) + 1;

int nameless_file() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  return error ? -1 : ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
}

}  // namespace

WorldHistory::WorldHistory(std::string path, std::size_t bodies, std::uint64_t first_tick)
    : path_(std::move(path)),
      bodies_(bodies),
      stride_(kBytesOfBody * bodies),
      first_tick_(first_tick),
      file_(nameless_file()),
      bytes_(stride_),
      thread_([this] { rebuild(); }) {}

WorldHistory::~WorldHistory() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
  if (file_ >= 0) close(file_);
}

std::string WorldHistory::note() const {
  const std::lock_guard lock(mutex_);
  return note_;
}

std::optional<sim::GlobalStatistics> WorldHistory::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

bool WorldHistory::read(std::uint64_t cycle, publication::Frame& frame) const {
  if (cycle >= cycles()) return false;
  std::vector<std::byte> bytes(stride_);
  if (pread(file_, bytes.data(), stride_, static_cast<off_t>(cycle * stride_)) != static_cast<ssize_t>(stride_))
    return false;
  frame.positions.resize(bodies_);
  frame.rotations.resize(bodies_);
  frame.roles.resize(bodies_);
  const std::byte* from = bytes.data();
  std::memcpy(frame.positions.data(), from, bodies_ * sizeof(Position));
  std::memcpy(frame.rotations.data(), from += bodies_ * sizeof(Position), bodies_ * sizeof(Rotation));
  std::memcpy(frame.roles.data(), from + bodies_ * sizeof(Rotation), bodies_);
  return true;
}

void WorldHistory::rebuild() {
  set_denormals_flush();
  Status status = Status::good();
  const Status thrown = caught([&] { status = run(); });
  {
    const std::lock_guard lock(mutex_);
    note_ = status.ok() ? thrown.message() : status.message();
  }
  done_.store(true, std::memory_order_release);
}

Status WorldHistory::run() {
  auto tape = session::open_tape(path_);
  if (!tape.ok()) return tape.status();
  if (const std::string why = session::why_not_rebuilt(tape.value()); !why.empty()) return Status::error(why);
  if (first_tick_ != 0) return Status::error("the tape begins in the middle of the run");
  if (file_ < 0) return Status::error("no temporary file can be made");
  auto session = session::session_of(tape.value());
  if (!session.ok()) return session.status();
  player_ = std::make_unique<session::TapePlayer>(std::move(session.value()->loop));
  rebuilder_ = std::make_unique<session::WorldRebuilder>(*session.value()->global);
  Status status = Status::good();
  bool damaged = false;
  loop::TapeRecord record;
  const auto note_damage = [&](const std::string&, std::uint64_t) { damaged = true; };
  while (status.ok() && !stop_.load(std::memory_order_relaxed) && next_record(tape.value(), record, note_damage))
    status = damaged || record.kind == loop::kTapeGap ? Status::error("records are missing") : take(record);
  if (status.ok()) {
    const std::lock_guard lock(mutex_);
    statistics_ = rebuilder_->world().statistics();
  }
  player_.reset();  // before the session that they are of
  rebuilder_.reset();
  return status;
}

Status WorldHistory::take(const loop::TapeRecord& record) {
  bool same = true;
  if (record.kind == loop::kKeyframeRecord) return player_->take_keyframe(record, same);
  if (record.kind == loop::kSnapshotRecord) {
    if (Status status = rebuilder_->take_snapshot(record); !status.ok()) return status;
    if (Status status = store(rebuilder_->world()); !status.ok()) return status;
    return player_->take_snapshot(record);
  }
  if (record.kind != loop::kTickRecord) return Status::good();
  const auto taped = session::tick_of(record);
  if (!taped.ok()) return taped.status();
  loop::TickOutput out;
  if (!player_->play(taped.value(), out)) return Status::error("records are missing");
  if (taped.value().adopts == 0) return Status::good();
  return rebuilder_->adopted(player_->report(), taped.value().member_budget);
}

Status WorldHistory::store(const sim::GlobalWorld& world) {
  const std::uint64_t cycle = cycles_.load(std::memory_order_relaxed);
  if ((cycle + 1) * stride_ > kMaxBytes)
    return Status::error(fmt::format("more than {} GiB would be needed", kMaxBytes >> 30));
  const auto bodies = world.bodies();
  if (bodies.size() != bodies_) return Status::error("the scene has other bodies than the tape");
  for (std::size_t i = 0; i < bodies_; ++i) {
    const Position position = publication::position_of(bodies[i].motion.pose.position);
    const Rotation rotation = publication::rotation_of(bodies[i].motion.pose.rotation);
    const std::uint8_t role = world.is_asleep(bodies[i].id) ? publication::kIsAsleep : 0;
    std::memcpy(bytes_.data() + i * sizeof position, &position, sizeof position);
    std::memcpy(bytes_.data() + bodies_ * sizeof position + i * sizeof rotation, &rotation, sizeof rotation);
    std::memcpy(bytes_.data() + bodies_ * (sizeof position + sizeof rotation) + i, &role, 1);
  }
  if (pwrite(file_, bytes_.data(), stride_, static_cast<off_t>(cycle * stride_)) != static_cast<ssize_t>(stride_))
    return Status::error("the temporary file is full");
  cycles_.store(cycle + 1, std::memory_order_release);
  return Status::good();
}

}  // namespace tactus::view
