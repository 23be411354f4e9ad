// Writes a FixedVector as its count and its elements, and reads it back.
//
// The elements beyond the count and the padding before the first one are not written: the same list gives the same
// bytes. Thread: [rt].
#pragma once

#include "rt/base/bounded_vector.h"
#include "rt/base/bytes.h"

namespace tactus {

template <class T, std::uint32_t kCapacity>
void write_list(ByteWriter& out, const FixedVector<T, kCapacity>& list) noexcept {
  out.put(list.count);
  out.put_all(list.span());
}

// False, with the list as it was, if the bytes end early or the count is above the capacity.
template <class T, std::uint32_t kCapacity>
[[nodiscard]] bool read_list(ByteReader& in, FixedVector<T, kCapacity>& list) noexcept {
  std::uint32_t count = 0;
  in.get(count);
  if (!in.ok() || count > kCapacity || count * sizeof(T) > in.remaining()) return false;
  list.count = count;
  in.get_all(list.span());
  return in.ok();
}

}  // namespace tactus
