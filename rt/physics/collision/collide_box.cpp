// The kernel of two boxes: finds the axis of largest separation among 15, then the contact points on it.
//
// Every axis gives a lower bound of the distance, so a gap is never reported larger than it is. A face axis is
// preferred to an edge axis, and the axis of the last step to any other, so that the manifold does not alternate. If
// two faces lean against each other and meet at their edges, the normal is between their normals.
#include <algorithm>
#include <cstring>

#include "rt/physics/collision/box_axes.h"
#include "rt/physics/collision/box_clip.h"
#include "rt/physics/collision/collide_boxes.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

struct BoxPair : BoxAxes<double> {
  const PairView& pair;

  // Gap between the projections of the boxes onto the unit vector n.
  double separation_along(const Vec3d& n) const noexcept {
    double extent = 0.0;
    for (int i = 0; i < 3; ++i) extent += h[i] * std::abs(dot(axis_a[i], n)) + h[3 + i] * std::abs(dot(axis_b[i], n));
    return std::abs(dot(n, b_from_a)) - extent;
  }
};

const Vec3d& face_axis(const BoxPair& boxes, int code) noexcept {
  return code < kFirstFaceB ? boxes.axis_a[code - 1] : boxes.axis_b[code - kFirstFaceB];
}

// Direction of an edge axis, not of length 1.
Vec3d edge_axis(const BoxPair& boxes, int code) noexcept {
  return cross(boxes.axis_a[(code - kFirstEdge) / 3], boxes.axis_b[(code - kFirstEdge) % 3]);
}

Vec3d towards_b(const BoxPair& boxes, const Vec3d& n) noexcept { return dot(n, boxes.b_from_a) < 0.0 ? -n : n; }

// Chooses the face with the largest separation, or the last step's if it is about as good. Otherwise, of the faces that
// are about as good as the best, the one across which its box is thinnest (the lower code on a tie): if two cards meet
// edge to edge, their broad faces make the contact, not the narrow ones.
int choose_face(const BoxPair& boxes, const AxisTest& test, int cached) noexcept {
  const double best = test.face[test.widest - 1];
  const auto about_best = [&](int code) noexcept {
    const double separation = test.face[code - 1];
    return !(best > separation + axis_preference(separation));
  };
  if (cached >= 1 && cached < kFirstEdge && about_best(cached)) return cached;
  int chosen = 0;
  double thinnest = 0.0;
  for (int code = 1; code < kFirstEdge; ++code) {
    const double h = boxes.h[code - 1];
    if (!about_best(code) || (chosen != 0 && h >= thinnest)) continue;
    chosen = code;
    thinnest = h;
  }
  return chosen;
}

// A reference face and the other box, in the reference box's axes.
struct FaceFrame {
  bool on_a;    // the reference face is A's
  int i, u, v;  // its normal's axis and the two others
  double sign;  // outward along +i or -i
  const double *h, *h_other;
  const Vec3d* axis;
  double offset[3];     // centre of the other box
  double column[3][3];  // column[j]: axis j of the other box

  FaceFrame(const BoxPair& b, int code) noexcept
      : on_a(code < kFirstFaceB),
        i(on_a ? code - 1 : code - kFirstFaceB),
        u((i + 1) % 3),
        v((i + 2) % 3),
        h(on_a ? b.h : b.h + 3),
        h_other(on_a ? b.h + 3 : b.h),
        axis(on_a ? b.axis_a : b.axis_b) {
    for (int k = 0; k < 3; ++k) {
      offset[k] = on_a ? b.d_a[k] : -b.d_b[k];
      for (int j = 0; j < 3; ++j) column[j][k] = on_a ? b.r[k][j] : b.r[j][k];
    }
    sign = offset[i] < 0.0 ? -1.0 : 1.0;
  }

  Vec3d normal_to_b() const noexcept { return axis[i] * (on_a ? sign : -sign); }
};

// The face of the other box that is most opposite the reference face.
IncidentFace incident_face(const FaceFrame& f) noexcept {
  int j = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(f.column[k][f.i]) > std::abs(f.column[j][f.i])) j = k;
  const int k = (j + 1) % 3, l = (j + 2) % 3;
  const bool plus_j = !(f.sign * f.column[j][f.i] > 0.0);
  const auto half_side = [&](int axis) noexcept {
    const double* c = f.column[axis];
    const double h = f.h_other[axis];
    return IncidentFace::Along{h * c[f.u], h * c[f.v], f.sign * h * c[f.i]};
  };
  const auto side_j = half_side(j);
  const double sign_j = plus_j ? 1.0 : -1.0;
  IncidentFace face{.middle = {f.offset[f.u] + sign_j * side_j.u, f.offset[f.v] + sign_j * side_j.v,
                               f.sign * f.offset[f.i] + sign_j * side_j.w - f.h[f.i]},
                    .side_k = half_side(k),
                    .side_l = half_side(l)};
  // A corner's bits are the sides of the three axes on which it lies. An edge's label is its axis and the sides of the
  // two others. An edge runs along k where l stays, else along l.
  constexpr unsigned plus_k[4] = {1, 0, 0, 1}, plus_l[4] = {1, 1, 0, 0};
  const unsigned on_j = plus_j ? 1 : 0;
  for (unsigned n = 0; n < 4; ++n) {
    face.corner[n] = static_cast<std::uint8_t>(on_j << j | plus_k[n] << k | plus_l[n] << l);
    face.edge[n] = static_cast<std::uint8_t>(n % 2 == 0 ? 4 * static_cast<unsigned>(k) + plus_l[n] + 2 * on_j
                                                        : 4 * static_cast<unsigned>(l) + on_j + 2 * plus_k[n]);
  }
  return face;
}

// Adds up to four of the polygon's points within the margin. They are given on the other box's surface; contact points
// are midway between the surfaces.
void add_face_points(const BoxPair& boxes, const FaceFrame& f, ClipPolygon& polygon, Manifold& manifold) noexcept {
  keep_within(boxes.pair.margin, polygon);
  const std::uint32_t face =
      (f.on_a ? kFaceAType : kFaceBType) | static_cast<std::uint32_t>(f.i) << 9 | (f.sign > 0.0 ? 1u << 8 : 0u);
  mark_kept(boxes.pair, face, polygon);
  reduce_to_four(polygon);
  manifold.normal = f.normal_to_b();
  for (std::uint32_t n = 0; n < polygon.count; ++n) {
    const ClipPoint& p = polygon.points[n];
    const Vec3d mid = f.axis[f.i] * (f.sign * (f.h[f.i] + 0.5 * p.w)) + f.axis[f.u] * p.u + f.axis[f.v] * p.v;
    add_point(boxes.pair, manifold, f.on_a ? mid : mid + boxes.b_from_a, p.w, face | p.id);
  }
}

Vec3d nearest_in_box(const Vec3d* axis, const double* h, const Vec3d& point) noexcept {
  Vec3d nearest;
  for (int i = 0; i < 3; ++i) nearest += axis[i] * std::clamp(dot(axis[i], point), -h[i], h[i]);
  return nearest;
}

// A corner against a corner or an edge, where no part of a face is opposite the other box: finds the nearest points by
// alternating projections. A few rounds suffice, because the gap along any direction is a lower bound of the distance.
void add_closest_point(const BoxPair& boxes, const Vec3d& normal, double separation, double bound,
                       Manifold& manifold) noexcept {
  constexpr int kRounds = 8;
  const Vec3d& offset = boxes.b_from_a;
  Vec3d on_a = nearest_in_box(boxes.axis_a, boxes.h, offset), on_b;
  for (int round = 0; round < kRounds; ++round) {
    on_b = offset + nearest_in_box(boxes.axis_b, boxes.h + 3, on_a - offset);
    on_a = nearest_in_box(boxes.axis_a, boxes.h, on_b);
  }
  const Vec3d n = direction_or(on_b - on_a, normal);
  const double along = boxes.separation_along(n);
  const bool apart = along > 0.0 && along >= bound && dot(n, offset) > 0.0;
  manifold.normal = apart ? n : normal;
  add_point(boxes.pair, manifold, 0.5 * (on_a + on_b), apart ? along : bound > 0.0 ? bound : separation, kClosestType);
}

// `bound`: the largest lower bound of the distance that the axes gave; negative if the boxes overlap.
void add_face_contact(const BoxPair& boxes, int code, double separation, double bound, Manifold& manifold) noexcept {
  const FaceFrame f(boxes, code);
  ClipPolygon polygon = clip_to_rectangle(incident_face(f), f.h[f.u], f.h[f.v]);
  double lowest = 0.0;
  for (std::uint32_t n = 0; n < polygon.count; ++n)
    if (n == 0 || polygon.points[n].w < lowest) lowest = polygon.points[n].w;
  // If the lowest corner of the other box is beside the face, the points above the face are higher than the bound. A
  // small difference is subtracted from them; with a large one they are not the closest points.
  const double floor = bound > 0.0 ? bound : 0.0, excess = lowest - floor;
  if (polygon.count == 0 || excess > axis_preference(floor))
    return add_closest_point(boxes, f.normal_to_b(), separation, bound, manifold);
  for (std::uint32_t n = 0; n < polygon.count && excess > 0.0; ++n) polygon.points[n].w -= excess;
  add_face_points(boxes, f, polygon, manifold);
}

// Difference of the two separations up to which the normal is interpolated [m]: more than the overlap that resting
// contacts keep, less than can be felt.
constexpr double kRounding = 5e-5;

// Two faces lean against each other and meet at parallel edges, so the contact belongs to both. While the two axes are
// about equally deep, the normal is interpolated between the two faces' normals, as on rounded edges. With the normal
// of one face alone, the contact of two cards that lean against each other is asymmetric, and the pair sways until it
// falls.
void round_edges(const BoxPair& boxes, const AxisTest& test, int face, Manifold& manifold) noexcept {
  constexpr double kLooks = 0.5, kParallel = 0.999;  // cosines
  if (manifold.count != 2) return;
  const Vec3d own = towards_b(boxes, face_axis(boxes, face));
  Vec3d other;
  double deeper = -1.0;  // difference of the two separations / kRounding
  for (int k = 0; k < 3; ++k) {
    const int code = (face < kFirstFaceB ? kFirstFaceB : 1) + k;
    const Vec3d n = towards_b(boxes, face_axis(boxes, code));
    const double looks = dot(own, n), by = (test.face[code - 1] - test.face[face - 1]) / kRounding;
    if (looks > kLooks && looks < kParallel && by > deeper) {
      other = n;
      deeper = by;
    }
  }
  if (deeper > -1.0) manifold.normal = direction_or(own + 0.5 * (1.0 + std::min(deeper, 1.0)) * (other - own), own);
}

// Adds the points of two edges that cross nearly along a face's normal `n`: unit, from A to B. False if the edges do
// not meet above the face.
bool add_edges_above_face(const BoxPair& boxes, int face, const Vec3d& n, double separation,
                          Manifold& manifold) noexcept {
  const FaceFrame f(boxes, face);
  ClipPolygon polygon = clip_to_rectangle(incident_face(f), f.h[f.u], f.h[f.v]);
  if (!tilt_to_edges(dot(n, f.normal_to_b()), separation, polygon)) return false;
  add_face_points(boxes, f, polygon, manifold);
  manifold.normal = n;
  return true;
}

// Adds the midpoint of the closest points of the two edges that face each other along the axis `n`.
void add_edge_contact(const BoxPair& boxes, int code, const Vec3d& n, double separation, Manifold& manifold) noexcept {
  const int i = (code - kFirstEdge) / 3, j = (code - kFirstEdge) % 3;
  Vec3d centre_a, centre_b = boxes.b_from_a;
  std::uint32_t sides = 0;
  for (int k = 0; k < 3; ++k) {
    const bool plus_a = dot(boxes.axis_a[k], n) > 0.0, plus_b = dot(boxes.axis_b[k], n) < 0.0;
    if (k != i) centre_a += boxes.axis_a[k] * (plus_a ? boxes.h[k] : -boxes.h[k]);
    if (k != j) centre_b += boxes.axis_b[k] * (plus_b ? boxes.h[3 + k] : -boxes.h[3 + k]);
    sides |= (k != i && plus_a ? 1u << k : 0u) | (k != j && plus_b ? 8u << k : 0u);
  }
  const Vec3d half_a = boxes.axis_a[i] * boxes.h[i], half_b = boxes.axis_b[j] * boxes.h[3 + j];
  const auto [s, t] = closest_on_segments(half_a, half_b, centre_b - centre_a);
  manifold.normal = n;
  add_point(boxes.pair, manifold, 0.5 * (centre_a + half_a * s + centre_b + half_b * t), separation,
            kEdgeType | static_cast<std::uint32_t>(code) << 6 | sides);
}

// The value of Manifold::may_be_flush. A carried-over contact may move by less than kFlush.
bool may_be_flush(const BoxPair& boxes, const AxisTest& test, const Vec3d& n) noexcept {
  constexpr double kMost = 2.0 * kFlush;
  for (int code = 1; code < kFirstEdge; ++code)
    if (std::abs(test.face[code - 1]) <= kMost && std::abs(dot(face_axis(boxes, code), n)) < kAcrossCarried)
      return true;
  return false;
}

// The manifold of a pair that no axis separates, but for may_be_flush.
void add_near(const BoxPair& boxes, const AxisTest& test, Manifold& manifold, AxisCache& cache) noexcept {
  const int cached = cache.axis;
  const double widest = test.face[test.widest - 1];
  const double bound = test.edge != 0 ? std::max(widest, test.edge_separation) : widest;
  const int face = choose_face(boxes, test, cached);
  const double face_separation = test.face[face - 1];
  if (test.edge != 0) {
    const Vec3d axis = edge_axis(boxes, test.edge);
    const bool along_face = is_along_face(axis, face_axis(boxes, face));
    if (test.edge_separation > face_separation + edge_preference(face_separation, along_face, cached >= kFirstEdge)) {
      cache.axis = static_cast<std::uint8_t>(test.edge);
      const Vec3d n = towards_b(boxes, direction_or(axis, boxes.axis_a[0]));
      if (along_face && add_edges_above_face(boxes, face, n, test.edge_separation, manifold)) return;
      return add_edge_contact(boxes, test.edge, n, test.edge_separation, manifold);
    }
  }
  cache.axis = static_cast<std::uint8_t>(face);
  add_face_contact(boxes, face, face_separation, bound, manifold);
  round_edges(boxes, test, face, manifold);
}

void collide_near(const BoxPair& boxes, const AxisTest& test, Manifold& manifold, AxisCache& cache) noexcept {
  add_near(boxes, test, manifold, cache);
  manifold.may_be_flush = may_be_flush(boxes, test, manifold.normal);
}

// Four bodies, one a lane.
using V = Register<double>;
constexpr std::size_t kLaneCount = kBoxPairs;
static_assert(kLaneCount == static_cast<std::size_t>(kLanes<V>) && sizeof(BodyFrame) == 3 * sizeof(V));

struct Body4 {
  Vec3<V> position;
  BoxFrame<V> frame;
};

TACTUS_INLINE V load_part(const BodyFrame& frame, std::size_t part) noexcept {
  V::Native out;
  std::memcpy(&out, reinterpret_cast<const char*>(&frame) + part * sizeof(out), sizeof(out));
  return V::of(out);
}

// The frame and the half extents that `frame_of(lane)` and `half_of(lane)` return.
template <class FrameOf, class HalfOf>
TACTUS_INLINE Body4 load_bodies(FrameOf frame_of, HalfOf half_of) noexcept {
  const BodyFrame &f = frame_of(0), &g = frame_of(1), &k = frame_of(2), &l = frame_of(3);
  V m[3][4] = {{load_part(f, 0), load_part(g, 0), load_part(k, 0), load_part(l, 0)},
               {load_part(f, 1), load_part(g, 1), load_part(k, 1), load_part(l, 1)},
               {load_part(f, 2), load_part(g, 2), load_part(k, 2), load_part(l, 2)}};
  for (auto& rows : m) transpose(rows);
  const auto half = [&](double Vec3d::*c) noexcept {
    return V::of(V::Native{half_of(0).*c, half_of(1).*c, half_of(2).*c, half_of(3).*c});
  };
  return {.position = {m[0][0], m[0][1], m[0][2]},
          .frame = {.axis = {{m[0][3], m[1][0], m[1][1]}, {m[1][2], m[1][3], m[2][0]}, {m[2][1], m[2][2], m[2][3]}},
                    .half = {half(&Vec3d::x), half(&Vec3d::y), half(&Vec3d::z)}}};
}

}  // namespace

void collide_box_box(const PairView& pair, Manifold& manifold, AxisCache& cache) noexcept {
  const auto frame_of = [](const Quatd& world_from_box, const Shape& box) noexcept {
    const Axes axes = axes_of(world_from_box);
    return BoxFrame<double>{{axes.x, axes.y, axes.z}, box.half_extents};
  };
  const BoxPair boxes{box_axes(frame_of(pair.world_from_a, pair.a), frame_of(pair.world_from_b, pair.b), pair.b_from_a),
                      pair};
  const auto test = test_axes<double>(boxes, pair.margin);
  if (!(test.apart > 0.0)) return collide_near(boxes, pair_of_lane(test, 0), manifold, cache);
  const GapBound<double> bound = bound_gap<double>(boxes, test);
  manifold.gap = bound.gap;
  manifold.lever_arm = bound.lever_arm;
  cache.axis = static_cast<std::uint8_t>(test.apart);
}

void collide_boxes(std::span<const BoxPairQuery> pairs) noexcept {
  const auto pair_in = [pairs](std::size_t lane) noexcept -> const BoxPairQuery& {
    return pairs[lane < pairs.size() ? lane : 0];
  };
  const Body4 a = load_bodies(
      [&](std::size_t lane) noexcept -> auto& { return pair_in(lane).frame_a; },
      [&](std::size_t lane) noexcept -> auto& { return pair_in(lane).a.shape.half_extents; });
  const Body4 b = load_bodies(
      [&](std::size_t lane) noexcept -> auto& { return pair_in(lane).frame_b; },
      [&](std::size_t lane) noexcept -> auto& { return pair_in(lane).b.shape.half_extents; });
  const V margin = V::of(
      V::Native{pair_in(0).query.margin, pair_in(1).query.margin, pair_in(2).query.margin, pair_in(3).query.margin});
  const BoxAxes<V> boxes = box_axes(a.frame, b.frame, b.position - a.position);
  const auto test = test_axes(boxes, margin);
  const GapBound<V> bound = bound_gap(boxes, test);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const BoxPairQuery& pair = pairs[k];
    const int lane = static_cast<int>(k);
    const int apart = static_cast<int>(test.apart[lane]);
    pair.manifold.count = 0;
    pair.manifold.gap = apart != 0 ? bound.gap[lane] : 0.0;
    pair.manifold.lever_arm = apart != 0 ? bound.lever_arm[lane] : 0.0;
    pair.manifold.apart = {};
    if (apart != 0)
      pair.cache.axis = static_cast<std::uint8_t>(apart);
    else
      collide_near({pair_of_lane(boxes, lane), pair_view(pair.a, pair.b, pair.query)}, pair_of_lane(test, lane),
                   pair.manifold, pair.cache);
  }
}

}  // namespace tactus::physics
