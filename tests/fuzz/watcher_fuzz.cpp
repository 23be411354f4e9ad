// Any bytes are what the memory of a run that is watched holds: the watcher refuses it in one line, or reads frames and
// ticks of it and nothing outside.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "rt/tape/tape.h"
#include "tools/publication/watcher.h"

using namespace tactus::publication;

namespace {

// As a controller with one body lays it out.
Header good_header() {
  Header header;
  header.tape_version = tactus::loop::kTapeVersion;
  header.bodies = 1;
  header.text_offset = sizeof header;
  header.state_offset = 4096;
  header.frames_offset = header.state_offset + sizeof(StateSlot);
  header.frame_stride = rounded(slot_bytes(header.bodies), 4096);
  header.ticks_offset = header.frames_offset + kFrameSlots * header.frame_stride;
  header.tick_stride = sizeof(TickEntry);
  header.tick_entries = kTickEntries;
  header.bytes = header.ticks_offset + kTickEntries * sizeof(TickEntry);
  header.frames = header.ticks = 1;
  return header;
}

}  // namespace

// The first bytes replace the header's, from its ninth on; the rest is the first frame, and what the run
// says of itself.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  Header header = good_header();
  const std::size_t of_header = std::min(size, sizeof header - 8);
  const std::uint64_t bytes = header.bytes, frame_at = header.frames_offset, state_at = header.state_offset;
  std::memcpy(reinterpret_cast<unsigned char*>(&header) + 8, data, of_header);
  const int memory = memfd_create("fuzz", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (memory < 0 || ftruncate(memory, static_cast<off_t>(bytes)) != 0) std::abort();
  if (pwrite(memory, &header, sizeof header, 0) != sizeof header) std::abort();
  const std::size_t of_frame = size - of_header;
  if (pwrite(memory, data + of_header, of_frame, static_cast<off_t>(frame_at)) != static_cast<ssize_t>(of_frame))
    std::abort();
  const std::size_t of_state = std::min(of_frame, sizeof(StateSlot));
  if (pwrite(memory, data + of_header, of_state, static_cast<off_t>(state_at)) != static_cast<ssize_t>(of_state))
    std::abort();
  if (fcntl(memory, F_ADD_SEALS, F_SEAL_SHRINK) != 0) std::abort();
  auto opened = Watcher::open(memory);
  if (!opened.ok()) return opened.message().find('\n') == std::string::npos ? 0 : (std::abort(), 0);
  Frame frame;
  std::vector<TickEntry> ticks;
  if (opened.value()->read_frame(frame) && frame.contacts.size() > kMaxContacts) std::abort();
  (void)opened.value()->read_ticks(ticks, 16);
  if (ticks.size() > 16) std::abort();
  std::string state;
  if (opened.value()->read_state(state) && state.size() > sizeof(StateSlot)) std::abort();
  return 0;
}
