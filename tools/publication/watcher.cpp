#include "tools/publication/watcher.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "rt/tape/tape.h"
#include "tools/publication/shared_words.h"

namespace tactus::publication {
namespace {

constexpr int kFrameTries = 4;

// Everything that an offset or a count of the header leads to is inside of `size` bytes.
bool is_consistent(const Header& h, std::uint64_t size) {
  const auto inside = [&](std::uint64_t offset, std::uint64_t each, std::uint64_t count) {
    return offset % 8 == 0 && offset <= size && each <= size && count <= size && each * count <= size - offset;
  };
  return size < (std::uint64_t{1} << 31) && h.bytes == size && h.bodies < size &&
         inside(h.text_offset, 1, h.text_bytes) && h.frame_stride % 8 == 0 && h.frame_stride >= slot_bytes(h.bodies) &&
         inside(h.state_offset, sizeof(StateSlot), 1) && inside(h.frames_offset, h.frame_stride, kFrameSlots) &&
         h.tick_stride == sizeof(TickEntry) && h.tick_entries == kTickEntries &&
         inside(h.ticks_offset, h.tick_stride, h.tick_entries);
}

}  // namespace

Result<std::unique_ptr<Watcher>> Watcher::open(int descriptor) {
  const auto refuse = [&](const std::string& what) {
    close(descriptor);
    return Status::error("shared memory of the run: " + what);
  };
  struct stat status {};
  const int seals = fcntl(descriptor, F_GET_SEALS);
  // A memory that could shrink would end the reader by a signal.
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0 || fstat(descriptor, &status) != 0)
    return refuse("it is not sealed; accepted: what a running tactus passes on");
  const auto size = static_cast<std::uint64_t>(status.st_size);
  Header header;
  if (size < sizeof header) return refuse("it is too small for a header");
  const void* bytes = mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0);
  if (bytes == MAP_FAILED) return refuse("it cannot be mapped");
  std::memcpy(&header, bytes, sizeof header);
  std::string wrong;
  if (header.magic != kMagic)
    wrong = "it does not begin as one; accepted: what a running tactus passes on";
  else if (header.version != kPublicationVersion || header.tape_version != loop::kTapeVersion)
    wrong = fmt::format("layout {}.{}; this program reads {}.{}: use the run's own version", header.version,
                        header.tape_version, kPublicationVersion, loop::kTapeVersion);
  else if (!is_consistent(header, size))
    wrong = "its header is damaged";
  if (!wrong.empty()) {
    munmap(const_cast<void*>(bytes), size);
    return refuse(wrong);
  }
  return std::unique_ptr<Watcher>(new Watcher(descriptor, static_cast<const std::byte*>(bytes), header));
}

Watcher::Watcher(int descriptor, const std::byte* bytes, const Header& header)
    : descriptor_(descriptor),
      bytes_(bytes),
      header_(header),
      text_(reinterpret_cast<const char*>(bytes + header.text_offset), header.text_bytes) {}

Watcher::~Watcher() {
  munmap(const_cast<std::byte*>(bytes_), static_cast<std::size_t>(header_.bytes));
  close(descriptor_);
}

bool Watcher::ended() const noexcept { return load_word(bytes_ + offsetof(Header, ended)) != 0; }

bool Watcher::read_frame(Frame& frame) {
  for (int attempt = 0; attempt < kFrameTries; ++attempt) {
    const std::uint64_t written = load_word(bytes_ + offsetof(Header, frames));
    if (written <= next_frame_) return false;
    if (!copy_frame(written - 1, frame)) continue;
    frames_missed_ += written - 1 - next_frame_;
    next_frame_ = written;
    return true;
  }
  return false;
}

bool Watcher::copy_frame(std::uint64_t number, Frame& frame) const {
  const std::byte* const slot = bytes_ + header_.frames_offset + (number % kFrameSlots) * header_.frame_stride;
  const std::uint64_t complete = 2 * number + 2, bodies = header_.bodies;
  if (load_word(slot) != complete) return false;
  frame.number = number;
  load_words(&frame.head, slot, sizeof frame.head);
  if (frame.head.bodies > bodies || frame.head.contacts > kMaxContacts) return false;
  frame.positions.resize(rounded(bodies * sizeof(Position)) / sizeof(Position) + 1);
  frame.rotations.resize(bodies);
  frame.roles.resize(rounded(bodies));
  frame.contacts.resize(frame.head.contacts);
  load_words(frame.positions.data(), slot + positions_at(), rounded(bodies * sizeof(Position)));
  load_words(frame.rotations.data(), slot + rotations_at(bodies), bodies * sizeof(Rotation));
  load_words(frame.roles.data(), slot + roles_at(bodies), rounded(bodies));
  load_words(frame.contacts.data(), slot + contacts_at(bodies), frame.contacts.size() * sizeof(ContactForce));
  if (load_word(slot) != complete) return false;
  frame.positions.resize(frame.head.bodies);
  frame.rotations.resize(frame.head.bodies);
  frame.roles.resize(frame.head.bodies);
  return true;
}

bool Watcher::read_state(std::string& state) {
  const std::byte* const from = bytes_ + header_.state_offset;
  const std::uint64_t before = load_word(from);
  if (before == state_ || before % 2 != 0) return false;
  StateSlot slot;
  load_words(&slot, from, sizeof slot);
  if (load_word(from) != before || slot.bytes > slot.text.size()) return false;
  state.assign(slot.text.data(), slot.bytes);
  state_ = before;
  return true;
}

std::uint64_t Watcher::read_ticks(std::vector<TickEntry>& ticks, std::size_t most) {
  const std::uint64_t written = load_word(bytes_ + offsetof(Header, ticks));
  if (!began_ || written < next_tick_) next_tick_ = written;
  began_ = true;
  std::uint64_t lost = 0;
  if (written - next_tick_ > kTickEntries) {
    lost = written - next_tick_ - kTickEntries;
    next_tick_ += lost;
  }
  for (std::size_t taken = 0; next_tick_ < written && taken < most; ++next_tick_) {
    TickEntry tick;
    if (copy_tick(next_tick_, tick)) {
      ticks.push_back(tick);
      ++taken;
    } else {
      ++lost;
    }
  }
  return lost;
}

bool Watcher::copy_tick(std::uint64_t number, TickEntry& tick) const {
  const std::byte* const entry = bytes_ + header_.ticks_offset + (number % kTickEntries) * header_.tick_stride;
  const std::uint64_t complete = 2 * number + 2;
  if (load_word(entry) != complete) return false;
  load_words(&tick, entry, sizeof tick);
  return tick.sequence == complete && load_word(entry) == complete;
}

}  // namespace tactus::publication
