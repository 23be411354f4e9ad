// The motion of several bodies at once, one in each lane: how the wide kernels read and write SolverBody.
//
// A body is a run of 16 numbers, so N bodies are read by whole registers and turned from rows to columns. Thread: the
// owner of the World [rt]. Bound: constant. Units and frame: SolverBody's.
#pragma once

#include <cstddef>

#include "rt/base/wide.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

template <class V>
struct BodyLanes {
  using T = LaneOf<V>;
  static constexpr int kWidth = kLanes<V>;
  // The numbers of a body in the order of SolverBody: v, w, delta_position, delta_rotation.
  static constexpr int kRead = 13, kWritten = 6;

  Vec3<V> v, w, delta_position;
  Quat<V> delta_rotation;

  TACTUS_INLINE static BodyLanes gather(const SolverBody<T>* bodies, const std::uint32_t (&slot)[kWidth]) noexcept {
    V x[kNumbers];
    for (int block = 0; block < blocks(kRead); ++block) {
      V m[kWidth];
      for (int lane = 0; lane < kWidth; ++lane) load(m[lane], numbers_of(bodies[slot[lane]]) + block * kWidth);
      transpose(m);
      for (int i = 0; i < kWidth; ++i) x[block * kWidth + i] = m[i];
    }
    return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], x[8]}, {x[9], x[10], x[11], x[12]}};
  }

  // Writes v and w of the first `used` lanes (and what shares their registers, which is as it was).
  TACTUS_INLINE void scatter(SolverBody<T>* bodies, const std::uint32_t (&slot)[kWidth],
                             std::uint32_t used) const noexcept {
    const V x[8] = {v.x, v.y, v.z, w.x, w.y, w.z, delta_position.x, delta_position.y};
    for (int block = 0; block < blocks(kWritten); ++block) {
      V m[kWidth];
      for (int i = 0; i < kWidth; ++i) m[i] = x[block * kWidth + i];
      transpose(m);
      for (int lane = 0; lane < kWidth; ++lane)
        if (static_cast<std::uint32_t>(lane) < used) store(m[lane], numbers_of(bodies[slot[lane]]) + block * kWidth);
    }
  }

 private:
  static constexpr int kNumbers = 16;
  static constexpr int blocks(int numbers) noexcept { return (numbers + kWidth - 1) / kWidth; }
  static_assert(sizeof(SolverBody<T>) == kNumbers * sizeof(T) && offsetof(SolverBody<T>, v) == 0 &&
                offsetof(SolverBody<T>, w) == 3 * sizeof(T) &&
                offsetof(SolverBody<T>, delta_position) == 6 * sizeof(T) &&
                offsetof(SolverBody<T>, delta_rotation) == 9 * sizeof(T));

  static const T* numbers_of(const SolverBody<T>& body) noexcept { return reinterpret_cast<const T*>(&body); }
  static T* numbers_of(SolverBody<T>& body) noexcept { return reinterpret_cast<T*>(&body); }
};

}  // namespace tactus::physics
