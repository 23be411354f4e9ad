#include "tools/view/page_stream.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace tactus::view {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are sent as they are in memory");

constexpr float kMoved_m = 10e-6f;
constexpr int kTurned = 3;  // of a rotation's 32,767: 0.1 mrad of a half angle is 1.6, rounding included

template <class T>
void put(std::string& out, const T* values, std::size_t count) {
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

bool far_apart(const publication::Position& a, const publication::Position& b) noexcept {
  return std::abs(a.x - b.x) > kMoved_m || std::abs(a.y - b.y) > kMoved_m || std::abs(a.z - b.z) > kMoved_m;
}
bool far_apart(const publication::Rotation& a, const publication::Rotation& b) noexcept {
  return std::abs(a.w - b.w) > kTurned || std::abs(a.x - b.x) > kTurned || std::abs(a.y - b.y) > kTurned ||
         std::abs(a.z - b.z) > kTurned;
}

// In the order of kChannels.
std::array<float, kChannels.size()> channels_of(const publication::TickEntry& entry) noexcept {
  const loop::TickOutput& out = entry.tick.out;
  const auto real = [](double number) noexcept { return static_cast<float>(number); };
  const auto microseconds = [](std::uint64_t ns) noexcept {
    return static_cast<float>(static_cast<double>(ns) * 1e-3);
  };
  const Vec3d &force = out.command.wrench.force, &proxy = out.proxy.pose.position, &target = out.target.position;
  return {static_cast<float>(out.tick & 0xffffffu),
          real(force.x),
          real(force.y),
          real(force.z),
          real(proxy.x),
          real(proxy.y),
          real(proxy.z),
          real(target.x),
          real(target.y),
          real(target.z),
          real(out.device_energy_J),
          real(out.damped_energy_J),
          real(out.border_work_J),
          real(out.border_tank_J),
          static_cast<float>(out.members),
          static_cast<float>(out.border),
          static_cast<float>(out.contacts),
          static_cast<float>(entry.tick.sub_steps),
          real(out.deepest_m),
          microseconds(entry.times.wake_ns),
          microseconds(std::uint64_t{entry.times.read_ns} + entry.times.write_ns),
          microseconds(entry.times.compute_ns),
          static_cast<float>(static_cast<std::uint32_t>(out.fault)),
          static_cast<float>(out.status)};
}

}  // namespace

void PageStream::offer_frame() noexcept {
  if (frame_waits_) ++dropped_;
  frame_waits_ = true;
}

void PageStream::offer_ticks(const std::vector<publication::TickEntry>& ticks, std::uint64_t lost) {
  lost_ticks_ += static_cast<std::uint32_t>(lost);
  for (const publication::TickEntry& tick : ticks) {
    const auto channels = channels_of(tick);
    ticks_.insert(ticks_.end(), channels.begin(), channels.end());
  }
  if (!ticks.empty()) newest_woke_ns_ = ticks.back().times.woke_ns;
  const std::size_t waiting = ticks_.size() / kChannels.size();
  if (waiting <= kMaxTicks) return;
  const std::size_t over = waiting - kMaxTicks;
  lost_ticks_ += static_cast<std::uint32_t>(over);
  ticks_.erase(ticks_.begin(), ticks_.begin() + static_cast<std::ptrdiff_t>(over * kChannels.size()));
}

void PageStream::restart() noexcept {
  ticks_.clear();
  restarts_ = true;
}

void PageStream::acknowledge(std::uint32_t number) noexcept {
  if (number > acknowledged_ && number <= sent_) acknowledged_ = number;
}

bool PageStream::ready() const noexcept {
  return sent_ - acknowledged_ < kMaxUnacknowledged && (frame_waits_ || !ticks_.empty());
}

std::string PageStream::take(const publication::Frame& frame, std::int64_t now_ns) {
  WireHeader header;
  header.number = ++sent_;
  header.dropped = dropped_;
  header.lost_ticks = lost_ticks_;
  header.ticks = static_cast<std::uint32_t>(ticks_.size() / kChannels.size());
  header.flags = restarts_ ? kRestarts : 0u;
  if (newest_woke_ns_ > 0 && !ticks_.empty())
    header.tick_age_us = static_cast<float>(1e-3 * static_cast<double>(now_ns - newest_woke_ns_));
  std::string blocks;
  if (frame_waits_) {
    header.flags |= kHasFrame;
    header.time_s = frame.head.time_s;
    header.component = frame.head.component;
    header.left_out = frame.head.left_out;
    header.resets = frame.head.resets;
    header.contacts = static_cast<std::uint32_t>(frame.contacts.size());
    put_bodies(frame, header, blocks);
    put_roles(frame, header, blocks);
  }
  put(blocks, ticks_.data(), ticks_.size());
  if (frame_waits_) put(blocks, frame.contacts.data(), frame.contacts.size());
  ticks_.clear();
  frame_waits_ = first_ = restarts_ = false;
  std::string message;
  put(message, &header, 1);
  return message + blocks;
}

std::vector<std::uint32_t> PageStream::moved_bodies(const publication::Frame& frame) const {
  std::vector<std::uint32_t> moved;
  for (std::uint32_t i = 0; i < frame.positions.size(); ++i)
    if (far_apart(frame.positions[i], state_[i].position) || far_apart(frame.rotations[i], state_[i].rotation))
      moved.push_back(i);
  return moved;
}

void PageStream::put_bodies(const publication::Frame& frame, WireHeader& header, std::string& blocks) {
  const std::size_t bodies = frame.positions.size();
  const bool all = state_.size() != bodies;
  std::vector<std::uint32_t> moved;
  if (!all) moved = moved_bodies(frame);
  if (all || 6 * moved.size() > 5 * bodies) {
    header.flags |= kIsFull;
    moved.resize(bodies);
    for (std::uint32_t i = 0; i < bodies; ++i) moved[i] = i;
    if (all) state_.assign(bodies, {});
  } else {
    put(blocks, moved.data(), moved.size());
  }
  header.bodies = static_cast<std::uint32_t>(moved.size());
  for (const std::uint32_t i : moved) {
    put(blocks, &frame.positions[i], 1);
    state_[i].position = frame.positions[i];
  }
  for (const std::uint32_t i : moved) {
    put(blocks, &frame.rotations[i], 1);
    state_[i].rotation = frame.rotations[i];
  }
}

void PageStream::put_roles(const publication::Frame& frame, WireHeader& header, std::string& blocks) {
  for (std::uint32_t i = 0; i < frame.roles.size(); ++i) {
    if (!first_ && frame.roles[i] == state_[i].role) continue;
    const std::uint32_t word = (std::uint32_t{frame.roles[i]} << 24) | i;
    put(blocks, &word, 1);
    state_[i].role = frame.roles[i];
    ++header.roles;
  }
}

}  // namespace tactus::view
