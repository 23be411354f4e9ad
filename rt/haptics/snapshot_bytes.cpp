#include "rt/haptics/snapshot_bytes.h"

namespace tactus::haptics {
namespace {

template <class T, std::uint32_t kCapacity>
void write_list(ByteWriter& out, const FixedVector<T, kCapacity>& list) noexcept {
  out.put(list.count);
  out.put_all(list.span());
}

template <class T, std::uint32_t kCapacity>
bool read_list(ByteReader& in, FixedVector<T, kCapacity>& list) noexcept {
  std::uint32_t count = 0;
  in.get(count);
  if (!in.ok() || count > kCapacity) return false;
  list.count = count;
  in.get_all(list.span());
  return in.ok();
}

}  // namespace

void write_snapshot(ByteWriter& out, const WorldSnapshot& s) noexcept {
  out.put(s.cycle);
  out.put(s.global_time_s);
  out.put(s.dropped);
  out.put(s.component);
  out.put(s.proxy);
  write_list(out, s.members);
  write_list(out, s.joiners);
  write_list(out, s.warm_starts);
  write_list(out, s.border);
}

bool read_snapshot(ByteReader& in, WorldSnapshot& s) noexcept {
  in.get(s.cycle);
  in.get(s.global_time_s);
  in.get(s.dropped);
  in.get(s.component);
  in.get(s.proxy);
  return read_list(in, s.members) && read_list(in, s.joiners) && read_list(in, s.warm_starts) &&
         read_list(in, s.border);
}

}  // namespace tactus::haptics
