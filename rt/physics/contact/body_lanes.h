// The motion of several bodies, one in each SIMD lane: how the wide kernels read and write SolverBody.
//
// A SolverBody is 16 contiguous numbers, so N bodies are read with whole registers and transposed. Thread: the owner of
// the World [rt]. Bound: constant. Units and frame: those of SolverBody.
#pragma once

#include <cstddef>

#include "rt/base/wide.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

// Number of registers that hold `numbers` numbers of a record.
template <class V>
constexpr int registers_for(int numbers) noexcept {
  return (numbers + kLanes<V> - 1) / kLanes<V>;
}

// Reads the first kCount numbers of the records at[0], at[1], ... into x: number i of each, lane by lane. Reads and
// fills whole registers.
template <int kCount, class Record, class V>
TACTUS_INLINE void gather_numbers(const Record* records, const std::uint32_t (&at)[kLanes<V>], V* x) noexcept {
  constexpr int kWidth = kLanes<V>;
  static_assert(sizeof(Record) >= sizeof(V) * registers_for<V>(kCount) && alignof(Record) >= sizeof(V));
  for (int k = 0; k < registers_for<V>(kCount); ++k) {
    V m[kWidth];
    for (int lane = 0; lane < kWidth; ++lane)
      load(m[lane], reinterpret_cast<const LaneOf<V>*>(records + at[lane]) + k * kWidth);
    transpose(m);
    for (int i = 0; i < kWidth; ++i) x[k * kWidth + i] = m[i];
  }
}

// Writes them back, to the first `used` records.
template <int kCount, class Record, class V>
TACTUS_INLINE void scatter_numbers(const V* x, Record* records, const std::uint32_t (&at)[kLanes<V>],
                                   std::uint32_t used) noexcept {
  constexpr int kWidth = kLanes<V>;
  for (int k = 0; k < registers_for<V>(kCount); ++k) {
    V m[kWidth];
    for (int i = 0; i < kWidth; ++i) m[i] = x[k * kWidth + i];
    transpose(m);
    const auto put = [&](int lane) noexcept {
      store(m[lane], reinterpret_cast<LaneOf<V>*>(records + at[lane]) + k * kWidth);
    };
    if (used == kWidth) [[likely]]
      for (int lane = 0; lane < kWidth; ++lane) put(lane);
    else
      for (int lane = 0; lane < kWidth; ++lane)
        if (static_cast<std::uint32_t>(lane) < used) put(lane);
  }
}

template <class V>
struct BodyLanes {
  using T = LaneOf<V>;
  static constexpr int kWidth = kLanes<V>;
  using Slots = std::uint32_t[kWidth];

  Vec3<V> v, w, delta_position;
  Quat<V> delta_rotation;
  V inverse_mass, gyroscopic;  // filled only by `read_all`

  // Reads what the sweeps need: everything except inverse_mass and gyroscopic.
  TACTUS_INLINE static BodyLanes read(const SolverBody<T>* bodies, const Slots& slot) noexcept {
    V x[kNumbers];
    gather_numbers<13>(bodies, slot, x);
    return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], x[8]}, {x[9], x[10], x[11], x[12]}, {}, {}};
  }
  // Reads v and w only.
  TACTUS_INLINE static BodyLanes read_velocities(const SolverBody<T>* bodies, const Slots& slot) noexcept {
    V x[kNumbers];
    gather_numbers<8>(bodies, slot, x);
    return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], V(0)}, {}, {}, {}};
  }
  TACTUS_INLINE static BodyLanes read_all(const SolverBody<T>* bodies, const Slots& slot) noexcept {
    V x[kNumbers];
    gather_numbers<kNumbers>(bodies, slot, x);
    return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], x[8]}, {x[9], x[10], x[11], x[12]}, x[13], x[14]};
  }

  // Writes v and w of the first `used` lanes. The rest of their registers (delta_position.x and .y) is written back
  // unchanged.
  TACTUS_INLINE void write_velocities(SolverBody<T>* bodies, const Slots& slot, std::uint32_t used) const noexcept {
    const V x[8] = {v.x, v.y, v.z, w.x, w.y, w.z, delta_position.x, delta_position.y};
    scatter_numbers<6>(x, bodies, slot, used);
  }
  TACTUS_INLINE void write_all(SolverBody<T>* bodies, const Slots& slot) const noexcept {
    const Vec3<V>& d = delta_position;
    const Quat<V>& q = delta_rotation;
    const V x[kNumbers] = {v.x, v.y, v.z, w.x, w.y, w.z,          d.x,        d.y,
                           d.z, q.w, q.x, q.y, q.z, inverse_mass, gyroscopic, V(0)};
    scatter_numbers<kNumbers>(x, bodies, slot, kWidth);
  }

 private:
  static constexpr int kNumbers = 16;
  static_assert(sizeof(SolverBody<T>) == kNumbers * sizeof(T) && offsetof(SolverBody<T>, v) == 0 &&
                offsetof(SolverBody<T>, w) == 3 * sizeof(T) &&
                offsetof(SolverBody<T>, delta_position) == 6 * sizeof(T) &&
                offsetof(SolverBody<T>, delta_rotation) == 9 * sizeof(T) &&
                offsetof(SolverBody<T>, inverse_mass) == 13 * sizeof(T) &&
                offsetof(SolverBody<T>, gyroscopic) == 14 * sizeof(T));
};

}  // namespace tactus::physics
