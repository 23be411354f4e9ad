// Clips a box's face to the outline of another box's face. Inside narrow phase. Thread: [any]; pure. Bound: four edges,
// each against four sides.
//
// Frame: that of the reference face: u, v along its sides, w outward. Units: m.
// Source: clipping of a line by its parameters where it enters and leaves, Liang and Barsky 1984.
#pragma once

#include "rt/base/wide.h"
#include "rt/physics/collision/clip_polygon.h"

namespace tactus::physics {

// The face of the incident box above the reference face: the corners middle + side_k + side_l, middle - side_k +
// side_l, middle - side_k - side_l and middle + side_k - side_l; edge n goes from corner n to the next.
struct IncidentFace {
  struct Along {
    double u{}, v{}, w{};  // m
  };
  Along middle{}, side_k{}, side_l{};
  std::array<std::uint8_t, 4> corner{};  // 0..7: which of the box's corners
  std::array<std::uint8_t, 4> edge{};    // 0..11: which of the box's edges
};

struct ClipPoint {
  double u, v, w;   // m
  std::uint8_t id;  // see below
  bool kept;        // was a point of the last step's manifold
};

// Ids: corners of the incident box 0..7; from kFirstCrossing the crossings of its edges with the sides, four an edge;
// from kFirstOfRectangle the corners of the rectangle.
inline constexpr std::uint8_t kFirstCrossing = 8, kFirstOfRectangle = kFirstCrossing + 4 * 12;

// At most two points an edge and the rectangle's corners.
inline constexpr std::uint32_t kMaxClipPoints = 12;

struct ClipPolygon {
  std::uint32_t count{0};
  std::array<ClipPoint, kMaxClipPoints + 1> points;  // one more, since points are written before they are counted
};

// Four numbers: of the face's corners or edges, or of the rectangle's corners, one a lane.
using V4 = Wide<double, 4>;
struct Points4 {
  V4 u, v, w;
};

// Signs of side_k and side_l in the corners; of u and v in the rectangle's corners, corner k between the sides k and
// k + 1. The rectangle's sides are numbered counter-clockwise from +u.
TACTUS_INLINE V4 signs_k() noexcept { return V4::of(V4::Native{1.0, -1.0, -1.0, 1.0}); }
TACTUS_INLINE V4 signs_l() noexcept { return V4::of(V4::Native{1.0, 1.0, -1.0, -1.0}); }

// Where each edge enters the rectangle and leaves it.
struct EdgeSpans {
  V4 enter, leave;             // in parts of the edge's length; below 0 and above 1 where it starts and ends inside
  V4 side_entered, side_left;  // the side there
  unsigned within, enters, leaves;  // bit n: edge n has a part inside; is not inside from its start; to its end
};

// `beyond[s]` [m]: how far the corners are beyond side s.
TACTUS_INLINE EdgeSpans spans_inside(const V4 (&beyond)[4]) noexcept {
  V4 enter(-1.0), leave(2.0), side_entered(0.0), side_left(0.0);
  const V4 tolerance(kSideTolerance), zero(0.0);
  auto outside = zero > zero;
  for (int s = 0; s < 4; ++s) {
    const V4 from = beyond[s], to = next_lane(from);
    const auto starts = from <= tolerance, ends = to <= tolerance;
    // If the inner end is itself beyond the side, within the tolerance, the crossing is at the end of the tolerance.
    const V4 shift = select(both(from > zero, to > zero), tolerance, zero);
    const V4 at = (from - shift) / (from - to);
    const auto enters = both(both(~starts, ends), at > enter), leaves = both(both(starts, ~ends), at < leave);
    enter = select(enters, at, enter);
    side_entered = select(enters, V4(s), side_entered);
    leave = select(leaves, at, leave);
    side_left = select(leaves, V4(s), side_left);
    outside |= both(~starts, ~ends);
  }
  const unsigned within = bits_of(both(~outside, enter <= leave));
  return {.enter = enter,
          .leave = leave,
          .side_entered = side_entered,
          .side_left = side_left,
          .within = within,
          .enters = within & bits_of(enter > V4(-1.0)),
          .leaves = within & bits_of(leave < V4(2.0))};
}

// The rectangle's corners on the plane of the face.
struct RectangleOnFace {
  Points4 corner;
  unsigned within;         // bit k: corner k is on the face
  bool counter_clockwise;  // the order of the face's own corners
};

TACTUS_INLINE RectangleOnFace rectangle_on(const IncidentFace& face, double half_u, double half_v) noexcept {
  const auto &k = face.side_k, &l = face.side_l;
  const V4 u = signs_k() * V4(half_u), v = signs_l() * V4(half_v);
  const V4 du = u - V4(face.middle.u), dv = v - V4(face.middle.v);
  // A point of the plane is the middle and a share of either half side, on the face if both are at most 1.
  const double area = k.u * l.v - k.v * l.u;
  const V4 share_k = (du * V4(l.v) - dv * V4(l.u)) / V4(area), share_l = (dv * V4(k.u) - du * V4(k.v)) / V4(area);
  const V4 whole(1.0 + 1e-9);  // rounding, where an edge goes through the corner
  return {.corner = {u, v, V4(face.middle.w) + share_k * V4(k.w) + share_l * V4(l.w)},
          .within = bits_of(both(abs(share_k) <= whole, abs(share_l) <= whole)),
          .counter_clockwise = area > 0.0};
}

// The part of the face within |u| <= half_u, |v| <= half_v, as a polygon in the order of the face's corners; empty if
// nothing is left. A corner beyond a side by at most 10 um is kept unchanged; of points within 20 um of each other one
// is kept.
inline ClipPolygon clip_to_rectangle(const IncidentFace& face, double half_u, double half_v) noexcept {
  const auto corners = [&](double IncidentFace::Along::*c) noexcept {
    return V4(face.middle.*c) + signs_k() * V4(face.side_k.*c) + signs_l() * V4(face.side_l.*c);
  };
  const Points4 corner{corners(&IncidentFace::Along::u), corners(&IncidentFace::Along::v),
                       corners(&IncidentFace::Along::w)};
  const auto along_edge = [&](const V4& share) noexcept {
    const auto between = [&](const V4& c) noexcept { return c + share * (next_lane(c) - c); };
    return Points4{between(corner.u), between(corner.v), between(corner.w)};
  };
  const EdgeSpans spans =
      spans_inside({corner.u - V4(half_u), corner.v - V4(half_v), -corner.u - V4(half_u), -corner.v - V4(half_v)});
  const RectangleOnFace rectangle = rectangle_on(face, half_u, half_v);
  const Points4 first = along_edge(larger(spans.enter, V4(0.0))), last = along_edge(spans.leave);

  ClipPolygon polygon;
  const auto add = [&polygon](const Points4& from, int lane, unsigned id, unsigned count) noexcept {
    polygon.points[polygon.count] = {
        .u = from.u[lane], .v = from.v[lane], .w = from.w[lane], .id = static_cast<std::uint8_t>(id), .kept = false};
    polygon.count += count;
  };
  const auto has = [](unsigned bits, int n) noexcept { return bits >> n & 1u; };
  const auto add_of_rectangle = [&](int k, unsigned count) noexcept {
    add(rectangle.corner, k, kFirstOfRectangle + static_cast<unsigned>(k), count);
  };
  const bool forwards = rectangle.counter_clockwise;
  for (int n = 0; n < 4 && spans.within == 0; ++n) {
    const int k = forwards ? n : 3 - n;
    add_of_rectangle(k, has(rectangle.within, k));
  }
  for (int n = 0; n < 4; ++n) {
    const auto edge = static_cast<std::size_t>(n);
    const auto crossing = [&](const V4& side) noexcept {
      return kFirstCrossing + 4u * face.edge[edge] + static_cast<unsigned>(side[n]);
    };
    add(first, n, has(spans.enters, n) ? crossing(spans.side_entered) : face.corner[edge], has(spans.within, n));
    if (!has(spans.leaves, n)) continue;
    add(last, n, crossing(spans.side_left), 1);
    // From here on the polygon follows the rectangle, to the side where an edge enters again.
    int next = (n + 1) % 4;
    while (!has(spans.within, next)) next = (next + 1) % 4;
    const int until = static_cast<int>(spans.side_entered[next]);
    for (int side = static_cast<int>(spans.side_left[n]); side != until;) {
      const int before = (side + 3) % 4, k = forwards ? side : before;
      if (!has(rectangle.within, k)) break;
      add_of_rectangle(k, 1);
      side = forwards ? (side + 1) % 4 : before;
    }
  }
  merge_neighbours(polygon);
  return polygon;
}

}  // namespace tactus::physics
