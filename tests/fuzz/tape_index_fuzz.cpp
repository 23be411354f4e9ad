// Any records, whole and damaged, are what follows a tape's header: the index of the tape is refused in one line, or it
// leads to keyframes that can be read, in their order, and to no more faults than it may hold.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>

#include "tools/view/tape_index.h"

using namespace tactus;

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

constexpr std::uint32_t kKinds[] = {loop::kKeyframeRecord,
                                    loop::kSnapshotRecord,
                                    loop::kTickRecord,
                                    loop::kTimesRecord,
                                    loop::kTapeGap,
                                    loop::kBodiesRecord,
                                    77};

// A tick whose number and fault are of the bytes; the loop wrote the rest.
loop::TickRecord tick_of(std::span<const unsigned char> bytes) {
  loop::TickRecord tick;
  std::memcpy(&tick.out.tick, bytes.data(), std::min(bytes.size(), sizeof tick.out.tick));
  if (bytes.size() > 8) tick.out.fault = static_cast<Fault>(bytes[8]);
  if (bytes.size() > 9) tick.adopts = bytes[9];
  return tick;
}

// Of each record the kind, the size of what it takes, and that; a kind of 255: the rest of the bytes as they are.
void write(const std::string& path, std::span<const unsigned char> bytes) {
  auto tape = loop::TapeWriter::create(path, "{}");
  require(tape.ok());
  while (bytes.size() >= 2 && bytes[0] != 255) {
    const std::uint32_t kind = kKinds[bytes[0] % std::size(kKinds)];
    const auto payload = bytes.subspan(2, std::min<std::size_t>(bytes[1], bytes.size() - 2));
    bytes = bytes.subspan(2 + payload.size());
    const bool whole_tick = kind == loop::kTickRecord && payload.size() % 2 == 0;
    const loop::TickRecord tick = tick_of(payload);
    const auto written =
        whole_tick ? std::as_bytes(std::span<const loop::TickRecord, 1>(&tick, 1)) : std::as_bytes(payload);
    require(tape.value()->write(kind, written).ok());
  }
  (void)tape.value()->close();  // of memory: there is nothing to wait for
  tape.value().reset();
  std::FILE* const file = std::fopen(path.c_str(), "ab");
  require(file != nullptr);
  if (!bytes.empty()) require(std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size());
  std::fclose(file);
}

void check(session::OpenTape& tape, const view::TapeIndex& index) {
  require(!index.keyframes.empty() && index.keyframes.size() <= index.ticks);
  require(index.faults.size() <= view::kMaxFaults && (index.damages != 0) == !index.damage.empty());
  std::uint64_t offset = 0;
  for (const auto& keyframe : index.keyframes) {
    require(keyframe.offset > offset && keyframe.tick <= index.last_tick);
    offset = keyframe.offset;
    loop::TapeRecord record;
    require(tape.reader->go_to(keyframe.offset, keyframe.index));
    require(tape.reader->next(record) == loop::TapeRead::kRecord && record.kind == loop::kKeyframeRecord);
  }
  for (const std::uint64_t tick : {std::uint64_t{0}, index.first_tick, index.last_tick, ~std::uint64_t{0}})
    require(index.keyframe_before(tick) < index.keyframes.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const int memory = memfd_create("fuzz", MFD_CLOEXEC);
  require(memory >= 0);
  const std::string path = "/proc/self/fd/" + std::to_string(memory);
  write(path, {data, size});
  auto reader = loop::TapeReader::open(path);
  require(reader.ok());
  session::OpenTape tape{path, std::move(reader).value(), {}, {}};
  const auto index = view::index_of(tape);
  if (index.ok())
    check(tape, index.value());
  else
    require(index.message().find('\n') == std::string::npos);
  tape.reader.reset();
  close(memory);
  return 0;
}
