// The newest records in memory, starting at a keyframe, for the dump of a fault.
//
// A byte ring. When it is full, the oldest keyframe and all records that depend on it are removed, so the content can
// always be replayed from its first record. Thread: one owner at a time, normal priority ([setup]).
// Bound: the capacity. Records before the first keyframe, and records larger than the capacity, are not kept but
// counted. A capacity of three keyframe intervals always keeps at least two of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace tactus::loop {

class TapeHistory {
 public:
  TapeHistory(std::size_t capacity_bytes, std::uint32_t keyframe_kind)
      : bytes_(capacity_bytes), keyframe_kind_(keyframe_kind) {}

  void push(std::uint32_t kind, std::span<const std::byte> payload);

  // Calls visit(kind, payload) for each record, oldest first. The payload is valid during the call.
  template <class Visit>
  void for_each(Visit&& visit) const {
    std::vector<std::byte> payload;
    for (std::uint64_t at = begin_; at < end_;) {
      const Start start = start_at(at);
      payload.resize(start.size);
      copy_out(at + sizeof start, payload);
      visit(start.kind, std::span<const std::byte>(payload));
      at += sizeof start + start.size;
    }
  }

  bool empty() const noexcept { return begin_ == end_; }
  std::size_t bytes() const noexcept { return static_cast<std::size_t>(end_ - begin_); }
  std::uint64_t not_kept() const noexcept { return not_kept_; }  // records that were not stored

 private:
  struct Start {
    std::uint32_t kind{0}, size{0};
  };
  Start start_at(std::uint64_t at) const;
  void drop_oldest_interval();
  void copy_in(std::uint64_t at, std::span<const std::byte> from);
  void copy_out(std::uint64_t at, std::span<std::byte> to) const;

  std::vector<std::byte> bytes_;
  std::uint32_t keyframe_kind_;
  std::uint64_t begin_{0}, end_{0};      // positions in bytes since the start; modulo the capacity in bytes_
  std::deque<std::uint64_t> keyframes_;  // positions; the first is begin_ unless empty
  std::uint64_t not_kept_{0};
};

}  // namespace tactus::loop
