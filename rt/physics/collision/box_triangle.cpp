#include "rt/physics/collision/box_triangle.h"

namespace tactus::physics {
namespace {

using V = Wide<double, 4>;  // lanes: the triangle's edges, the first of them twice

// The edge of the box along an axis, by the corner at its lower end.
struct EdgesByCorner {
  std::uint8_t of[3][8]{};
};
constexpr EdgesByCorner make_edges_by_corner() noexcept {
  EdgesByCorner edges;
  for (std::uint32_t e = 0; e < kBoxTopology.edges; ++e) {
    const unsigned from = kBoxTopology.edge[e].from, to = kBoxTopology.edge[e].to,
                   axis = (from ^ to) >> 1;  // bit 0, 1, 2
    edges.of[axis][from & to] = static_cast<std::uint8_t>(e);
  }
  return edges;
}
constexpr EdgesByCorner kEdgesByCorner = make_edges_by_corner();

}  // namespace

BoxFace best_box_face(const BoxTriangle& pair) noexcept {
  const auto& c = pair.corner;
  double separation[6];
  std::uint32_t nearest = 0;
  double highest = 0.0;
  for (std::uint32_t f = 0; f < 6; ++f) {
    const int i = static_cast<int>(f / 2);
    const double sign = f % 2 == 0 ? -1.0 : 1.0, height = sign * pair.middle[i] - pair.half[i];
    separation[f] = smaller(sign * c[0][i], smaller(sign * c[1][i], sign * c[2][i])) - pair.half[i];
    if (f > 0 && !(height > highest)) continue;
    nearest = f;
    highest = height;
  }
  BoxFace best{nearest, separation[nearest]};
  for (std::uint32_t f = 0; f < 6; ++f)
    if (separation[f] > best.separation) best = {f, separation[f]};
  return best;
}

EdgeAxis best_box_edges(const BoxTriangle& pair, double at_least) noexcept {
  const auto& c = pair.corner;
  const auto lanes_of = [](double a, double b, double d) noexcept { return V::of(V::Native{a, b, d, a}); };
  const V zero(0.0);
  V from[3], along[3];
  V from_middle[3];
  for (int i = 0; i < 3; ++i) {
    from[i] = lanes_of(c[0][i], c[1][i], c[2][i]);
    along[i] = lanes_of(c[1][i], c[2][i], c[0][i]) - from[i];
    from_middle[i] = from[i] - V(pair.middle[i]);
  }
  const V least_sine = V(kParallelSineSquared) * (along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
  EdgeAxis best;
  best.separation = at_least;
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    // along x axis j: components k and l.
    const V w_k = along[l], w_l = -along[k];
    const V length_squared = w_k * w_k + w_l * w_l;
    // Outward of the triangle; the middle of the triangle is inside it.
    const auto inward = w_k * from_middle[k] + w_l * from_middle[l] < zero;
    const V scale = select(inward, V(-1.0), V(1.0)) / sqrt(length_squared);
    const V n_k = w_k * scale, n_l = w_l * scale;
    const V separation = -(n_k * from[k] + n_l * from[l]) - (V(pair.half[k]) * abs(n_k) + V(pair.half[l]) * abs(n_l));
    const auto better = both(least_sine < length_squared, V(best.separation) < separation);
    if (!any(better)) continue;
    for (int e = 0; e < 3; ++e) {
      if (!(length_squared[e] > least_sine[e] && separation[e] > best.separation)) continue;
      best.found = true;
      best.edge = static_cast<std::uint32_t>(e);
      best.separation = separation[e];
      best.normal = {};
      best.normal[k] = n_k[e];
      best.normal[l] = n_l[e];
      // The box's edge is farthest against the normal.
      const unsigned corner = (n_k[e] < 0.0 ? 1u << k : 0u) | (n_l[e] < 0.0 ? 1u << l : 0u);
      best.other_edge = kEdgesByCorner.of[j][corner];
    }
  }
  return best;
}

}  // namespace tactus::physics
