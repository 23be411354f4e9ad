// Several numbers at once: the lanes of one vector register.
//
// Wide<T, N> behaves like a number, lane by lane, so that a kernel written for a type V works on one number (V = T) and
// on N at once, with the same bits in each lane: every operation is an IEEE operation, none is fused, and min, max and
// select are defined by one comparison. Comparisons give a Mask; branches become `select`. Based on the compilers'
// vector types: a target without such registers uses several smaller ones. Two operations that those types lack use
// compiler builtins: the header of intrinsics would be a quarter of all that a file of tactus reads.
// Thread: [any]. Bound: no function allocates or loops beyond N.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

namespace tactus {

#define TACTUS_INLINE [[gnu::always_inline]] inline

template <class T, int N>
struct Wide {
  using Lane = T;
  typedef T Native __attribute__((vector_size(N * sizeof(T))));
  typedef T InMemory __attribute__((vector_size(N * sizeof(T)), may_alias));
  using Mask = decltype(Native{} < Native{});

  Native v{};

  Wide() = default;
  template <class U>
  requires std::is_arithmetic_v<U> TACTUS_INLINE explicit Wide(U x) noexcept : v(static_cast<T>(x) - Native{}) {}
  TACTUS_INLINE static Wide of(Native native) noexcept {
    Wide out;
    out.v = native;
    return out;
  }

  TACTUS_INLINE T operator[](int lane) const noexcept { return v[lane]; }
  TACTUS_INLINE void set(int lane, T x) noexcept { v[lane] = x; }

  TACTUS_INLINE friend Wide operator+(Wide a, Wide b) noexcept { return of(a.v + b.v); }
  TACTUS_INLINE friend Wide operator-(Wide a, Wide b) noexcept { return of(a.v - b.v); }
  TACTUS_INLINE friend Wide operator*(Wide a, Wide b) noexcept { return of(a.v * b.v); }
  TACTUS_INLINE friend Wide operator/(Wide a, Wide b) noexcept { return of(a.v / b.v); }
  TACTUS_INLINE friend Wide operator-(Wide a) noexcept { return of(-a.v); }
  TACTUS_INLINE Wide& operator+=(Wide o) noexcept {
    v += o.v;
    return *this;
  }
  TACTUS_INLINE Wide& operator-=(Wide o) noexcept {
    v -= o.v;
    return *this;
  }
  TACTUS_INLINE Wide& operator*=(Wide o) noexcept {
    v *= o.v;
    return *this;
  }
  TACTUS_INLINE friend Mask operator<(Wide a, Wide b) noexcept { return a.v < b.v; }
  TACTUS_INLINE friend Mask operator>(Wide a, Wide b) noexcept { return a.v > b.v; }
  TACTUS_INLINE friend Mask operator<=(Wide a, Wide b) noexcept { return a.v <= b.v; }

  TACTUS_INLINE friend Wide select(Mask which, Wide yes, Wide no) noexcept { return of(which ? yes.v : no.v); }
  TACTUS_INLINE friend Wide abs(Wide a) noexcept {
    return of(reinterpret_cast<Native>(reinterpret_cast<Mask>(a.v) & ~reinterpret_cast<Mask>(-Native{})));
  }
  TACTUS_INLINE friend Wide sqrt(Wide a) noexcept {
#if defined(__AVX__)
    if constexpr (sizeof(Native) == 32 && sizeof(T) == 4) return of(__builtin_ia32_sqrtps256(a.v));
    if constexpr (sizeof(Native) == 32 && sizeof(T) == 8) return of(__builtin_ia32_sqrtpd256(a.v));
#endif
    for (int i = 0; i < N; ++i) a.v[i] = std::sqrt(a.v[i]);
    return a;
  }
};

// The same functions for one number.
TACTUS_INLINE float select(bool which, float yes, float no) noexcept { return which ? yes : no; }
TACTUS_INLINE double select(bool which, double yes, double no) noexcept { return which ? yes : no; }

// For masks, or for one comparison.
TACTUS_INLINE bool both(bool a, bool b) noexcept { return a && b; }
TACTUS_INLINE bool any(bool which) noexcept { return which; }
template <class Mask>
requires(sizeof(Mask) > sizeof(Mask{}[0])) TACTUS_INLINE Mask both(Mask a, Mask b)
noexcept { return a & b; }
template <class Mask>
requires(sizeof(Mask) > sizeof(Mask{}[0])) TACTUS_INLINE bool any(Mask which) noexcept {
#if defined(__AVX__)
  if constexpr (sizeof(Mask) == 32) {
    typedef long long Bits __attribute__((vector_size(32)));
    return __builtin_ia32_ptestz256((Bits)which, (Bits)which) == 0;
  }
#endif
  bool found = false;
  for (std::size_t i = 0; i < sizeof(Mask) / sizeof(which[0]); ++i) found |= which[i] != 0;
  return found;
}

// Lane k + 1 in lane k, the first in the last.
TACTUS_INLINE Wide<double, 4> next_lane(Wide<double, 4> a) noexcept {
  return Wide<double, 4>::of(__builtin_shufflevector(a.v, a.v, 1, 2, 3, 0));
}

// Bit k is set where lane k is.
template <class Mask>
requires(sizeof(Mask) > sizeof(Mask{}[0])) TACTUS_INLINE unsigned bits_of(Mask which) noexcept {
  constexpr std::size_t lanes = sizeof(Mask) / sizeof(which[0]);
#if defined(__AVX__)
  if constexpr (sizeof(Mask) == 32 && lanes == 4)
    return static_cast<unsigned>(__builtin_ia32_movmskpd256(reinterpret_cast<Wide<double, 4>::Native>(which)));
  if constexpr (sizeof(Mask) == 32 && lanes == 8)
    return static_cast<unsigned>(__builtin_ia32_movmskps256(reinterpret_cast<Wide<float, 8>::Native>(which)));
#endif
  unsigned bits = 0;
  for (std::size_t i = 0; i < lanes; ++i) bits |= which[i] != 0 ? 1u << i : 0u;
  return bits;
}

// Maximum and minimum; `a` if the operands are equal or not ordered (NaN).
template <class V>
TACTUS_INLINE V larger(V a, V b) noexcept {
  return select(a < b, b, a);
}
template <class V>
TACTUS_INLINE V smaller(V a, V b) noexcept {
  return select(b < a, b, a);
}

// The number type of V, and its number of lanes.
template <class V>
struct LanesOf {
  using Lane = V;
  static constexpr int kCount = 1;
};
template <class T, int N>
struct LanesOf<Wide<T, N>> {
  using Lane = T;
  static constexpr int kCount = N;
};
template <class V>
using LaneOf = typename LanesOf<V>::Lane;
template <class V>
inline constexpr int kLanes = LanesOf<V>::kCount;

// Number of lanes in one register of the target (x86-64-v3: 32 bytes).
template <class T>
using Register = Wide<T, static_cast<int>(32 / sizeof(T))>;

template <class T>
TACTUS_INLINE void set_lane(T& to, int, std::type_identity_t<T> x) noexcept {
  to = x;
}
template <class T, int N>
TACTUS_INLINE void set_lane(Wide<T, N>& to, int lane, std::type_identity_t<T> x) noexcept {
  to.set(lane, x);
}
template <class T>
requires std::is_floating_point_v<T> TACTUS_INLINE T lane_of(T from, int)
noexcept { return from; }
template <class T, int N>
TACTUS_INLINE T lane_of(const Wide<T, N>& from, int lane) noexcept {
  return from[lane];
}

// Transposes in place: afterwards m[i][k] is the former m[k][i]. As many rows as lanes.
template <class T>
requires std::is_floating_point_v<T> TACTUS_INLINE void transpose(T (&)[1]) noexcept {}

TACTUS_INLINE void transpose(Wide<double, 4> (&m)[4]) noexcept {
  const auto a = __builtin_shufflevector(m[0].v, m[1].v, 0, 4, 2, 6),
             b = __builtin_shufflevector(m[0].v, m[1].v, 1, 5, 3, 7);
  const auto c = __builtin_shufflevector(m[2].v, m[3].v, 0, 4, 2, 6),
             d = __builtin_shufflevector(m[2].v, m[3].v, 1, 5, 3, 7);
  m[0].v = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  m[1].v = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  m[2].v = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  m[3].v = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

TACTUS_INLINE void transpose(Wide<float, 8> (&m)[8]) noexcept {
  Wide<float, 8>::Native s[8], t[8];
  for (int i = 0; i < 8; i += 2) {  // pairs of rows: single numbers
    s[i] = __builtin_shufflevector(m[i].v, m[i + 1].v, 0, 8, 1, 9, 4, 12, 5, 13);
    s[i + 1] = __builtin_shufflevector(m[i].v, m[i + 1].v, 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (int i = 0; i < 8; i += 4) {  // four rows: pairs of numbers
    for (int k = 0; k < 2; ++k) {
      t[i + 2 * k] = __builtin_shufflevector(s[i + k], s[i + 2 + k], 0, 1, 8, 9, 4, 5, 12, 13);
      t[i + 2 * k + 1] = __builtin_shufflevector(s[i + k], s[i + 2 + k], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (int i = 0; i < 4; ++i) {  // all rows: halves
    m[i].v = __builtin_shufflevector(t[i], t[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    m[i + 4].v = __builtin_shufflevector(t[i], t[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// Load and store N consecutive numbers; the address must be aligned to their total size.
template <class T>
requires std::is_floating_point_v<T> TACTUS_INLINE void load(T& to, const T* from) noexcept { to = *from; }
template <class T, int N>
TACTUS_INLINE void load(Wide<T, N>& to, const T* from) noexcept {
  to.v = *reinterpret_cast<const typename Wide<T, N>::InMemory*>(from);
}
template <class T>
requires std::is_floating_point_v<T> TACTUS_INLINE void store(T from, T* to) noexcept { *to = from; }
template <class T, int N>
TACTUS_INLINE void store(const Wide<T, N>& from, T* to) noexcept {
  *reinterpret_cast<typename Wide<T, N>::InMemory*>(to) = from.v;
}

}  // namespace tactus
