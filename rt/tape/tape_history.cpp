#include "rt/tape/tape_history.h"

#include <algorithm>
#include <cstring>

namespace tactus::loop {

void TapeHistory::push(std::uint32_t kind, std::span<const std::byte> payload) {
  const Start start{kind, static_cast<std::uint32_t>(payload.size())};
  const std::uint64_t need = sizeof start + payload.size();
  const bool keyframe = kind == keyframe_kind_;
  while (!keyframes_.empty() && bytes_.size() - (end_ - begin_) < need) drop_oldest_interval();
  if (need > bytes_.size() || (keyframes_.empty() && !keyframe)) {
    ++not_kept_;
    return;
  }
  if (keyframe) keyframes_.push_back(end_);
  copy_in(end_, std::as_bytes(std::span<const Start, 1>(&start, 1)));
  copy_in(end_ + sizeof start, payload);
  end_ += need;
}

void TapeHistory::drop_oldest_interval() {
  keyframes_.pop_front();
  begin_ = keyframes_.empty() ? end_ : keyframes_.front();
}

TapeHistory::Start TapeHistory::start_at(std::uint64_t at) const {
  Start start;
  copy_out(at, std::as_writable_bytes(std::span<Start, 1>(&start, 1)));
  return start;
}

void TapeHistory::copy_in(std::uint64_t at, std::span<const std::byte> from) {
  const std::size_t place = static_cast<std::size_t>(at % bytes_.size());
  const std::size_t first = std::min(from.size(), bytes_.size() - place);
  std::copy_n(from.begin(), first, bytes_.begin() + static_cast<std::ptrdiff_t>(place));
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(first), from.end(), bytes_.begin());
}

void TapeHistory::copy_out(std::uint64_t at, std::span<std::byte> to) const {
  const std::size_t place = static_cast<std::size_t>(at % bytes_.size());
  const std::size_t first = std::min(to.size(), bytes_.size() - place);
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(place), first, to.begin());
  std::copy_n(bytes_.begin(), to.size() - first, to.begin() + static_cast<std::ptrdiff_t>(first));
}

}  // namespace tactus::loop
