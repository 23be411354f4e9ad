#include "tools/import/pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "sim/geometry/hull_builder.h"
#include "sim/geometry/hull_gap.h"
#include "tools/import/fragment.h"
#include "tools/import/solid_distance.h"

namespace tactus::scene_import {
std::size_t open_edges(const sim::TriangleSoup& soup) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> seen;  // by lower and higher corner: forth minus back, and all
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (const auto& t : soup.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t from = t[static_cast<std::size_t>(k)], to = t[static_cast<std::size_t>((k + 1) % 3)];
      const std::pair key{std::min(from, to), std::max(from, to)};
      seen[key] += from < to ? 1 : -1;
      ++count[key];
    }
  }
  std::size_t open = 0;
  for (const auto& [edge, times] : count)
    if (seen[edge] != 0 || times % 2 != 0) ++open;
  return open;
}

Result<double> hull_gap(const sim::TriangleSoup& soup, const HullPoints& hull) {
  auto built = sim::build_hull(hull.points);
  if (!built.ok()) return built.status();
  const auto gap = sim::find_hull_gap(soup, built.value().hull, built.value().given_from_body);
  if (!gap.ok()) return gap.status();
  return gap.value().gap_m > sim::kSmallestGap_m ? gap.value().gap_m : 0.0;
}

namespace {

constexpr double kRoundingShare = 1e-9;  // of the size: the rounding of a cut
constexpr unsigned kDivisions = 2'000;   // of a surface that is measured for a choice
constexpr double kSameVolume = 1e-3;     // of a piece's volume: planes that differ less leave as much
constexpr double kTolerance = 1.0 / 8;   // of the deviation that is wanted, in every measure

struct Solid {
  SolidDistance distance;
  double size_m, wanted_m, tolerance_m;
};

struct Piece {
  Fragment fragment;          // empty of a joined piece
  sim::TriangleSoup surface;  // of its hull
  double volume_m3{0};
  Excess excess;
  double thinning_m{0};  // by how much 64 vertices are less than its hull
  bool final{false};     // no plane divides it
  // For a choice: what is found and not yet excluded is taken to be within the tolerance.
  double error_m(double tolerance_m) const {
    return std::min(excess.bound_m, excess.found_m + tolerance_m) + thinning_m;
  }
};

double volume_of(const sim::TriangleSoup& surface) {
  const Vec3d origin = surface.corners.front();
  double six_volumes = 0;
  for (const auto& t : surface.triangles)
    six_volumes +=
        dot(surface.corners[t[0]] - origin, cross(surface.corners[t[1]] - origin, surface.corners[t[2]] - origin));
  return six_volumes / 6;
}

// The hull's surface, and within it two smaller ones about its middle, which see a hollow that the surface spans.
Excess measured(const sim::TriangleSoup& hull, const Solid& solid, unsigned divisions) {
  Vec3d middle;
  for (const Vec3d& corner : hull.corners) middle += corner * (1.0 / static_cast<double>(hull.corners.size()));
  sim::TriangleSoup all;
  for (const double scale : {1.0, 2.0 / 3, 1.0 / 3}) {
    const auto first = static_cast<std::uint32_t>(all.corners.size());
    for (const Vec3d& corner : hull.corners) all.corners.push_back(middle + scale * (corner - middle));
    for (const auto& t : hull.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return excess_of(all, solid.distance, solid.tolerance_m, divisions);
}

// Measures the piece; the thinning only of one that is near enough otherwise.
void measure(Piece& piece, const Solid& solid) {
  piece.excess = measured(piece.surface, solid, kDivisions);
  piece.thinning_m = 0;
  if (piece.surface.corners.size() <= physics::kMaxHullVertices || piece.excess.found_m > solid.wanted_m) return;
  const auto hull = hull_of(piece.surface.corners);
  piece.thinning_m = hull.ok() ? hull.value().deviation_m : 0;
}

std::optional<Piece> piece_of(Fragment fragment) {
  auto surface = sim::hull_surface(corners_of(fragment));
  if (!surface.ok()) return {};
  const double volume = volume_of(surface.value());
  return Piece{
      .fragment = std::move(fragment), .surface = std::move(surface).value(), .volume_m3 = volume, .excess = {}};
}

double diagonal_of(const Piece& piece) {
  const physics::Aabb box = box_of(piece.surface.corners);
  return norm(box.upper - box.lower);
}

// The two parts of the piece with the least volume together; of planes that leave as much, to a thousandth, the one
// whose longer part is the shortest: a ring is cut across, not into two flat rings. None where no plane leaves two
// solids.
std::optional<std::pair<Piece, Piece>> halves_of(const Piece& piece, const Solid& solid) {
  struct Choice {
    Plane plane;
    double sum_m3, longer_m;
  };
  std::vector<Choice> choices;
  const double rounding_m = kRoundingShare * solid.size_m;
  const auto halves = [&](const Plane& plane) -> std::optional<std::pair<Piece, Piece>> {
    Cut parts = cut(piece.fragment, plane, solid.distance, rounding_m);
    if (parts.below.triangles.empty() || parts.above.triangles.empty()) return {};
    auto below = piece_of(std::move(parts.below)), above = piece_of(std::move(parts.above));
    if (!below || !above) return {};
    return std::pair{std::move(*below), std::move(*above)};
  };
  for (const Plane& plane : planes_to_try(piece.fragment, piece.excess.at, rounding_m))
    if (const auto both = halves(plane))
      choices.push_back({plane, both->first.volume_m3 + both->second.volume_m3,
                         std::max(diagonal_of(both->first), diagonal_of(both->second))});
  if (choices.empty()) return {};
  const double least = std::ranges::min(choices, {}, &Choice::sum_m3).sum_m3;
  std::erase_if(choices, [&](const Choice& c) { return c.sum_m3 > least + kSameVolume * piece.volume_m3; });
  return halves(std::ranges::min_element(choices, {}, &Choice::longer_m)->plane);
}

std::vector<Piece> divided(const sim::TriangleSoup& soup, unsigned most, const Solid& solid) {
  std::vector<Piece> pieces;
  if (auto whole = piece_of(whole_of(soup))) {
    measure(*whole, solid);
    pieces.push_back(std::move(*whole));
  }
  while (!pieces.empty() && pieces.size() < most) {
    const auto worst = std::ranges::max_element(
        pieces, {}, [&](const Piece& p) { return p.final ? -1.0 : p.error_m(solid.tolerance_m); });
    if (worst->final || worst->error_m(solid.tolerance_m) <= solid.wanted_m) break;
    auto halves = halves_of(*worst, solid);
    if (!halves) {
      worst->final = true;
      continue;
    }
    measure(halves->first, solid);
    measure(halves->second, solid);
    *worst = std::move(halves->first);
    pieces.push_back(std::move(halves->second));
  }
  return pieces;
}

bool touch(const Piece& a, const Piece& b, double rounding_m) {
  return box_of(a.surface.corners).grown(rounding_m).overlaps(box_of(b.surface.corners));
}

// The hull of two pieces, if 64 vertices suffice.
std::optional<Piece> joined(const Piece& a, const Piece& b, const Solid& solid) {
  std::vector<Vec3d> corners = a.surface.corners;
  corners.insert(corners.end(), b.surface.corners.begin(), b.surface.corners.end());
  auto surface = sim::hull_surface(corners);
  if (!surface.ok() || surface.value().corners.size() > physics::kMaxHullVertices) return {};
  const double volume = volume_of(surface.value());
  Piece both{.fragment = {}, .surface = std::move(surface).value(), .volume_m3 = volume, .excess = {}};
  measure(both, solid);
  return both;
}

bool is_within(const Piece& inner, const Piece& outer, double rounding_m) {
  return std::ranges::all_of(inner.surface.corners, [&](const Vec3d& p) {
    return std::ranges::all_of(outer.surface.triangles, [&](const auto& t) {
      const auto& corners = outer.surface.corners;
      const Vec3d normal = cross(corners[t[1]] - corners[t[0]], corners[t[2]] - corners[t[0]]);
      return dot(normal, p - corners[t[0]]) <= rounding_m * norm(normal);
    });
  });
}

// Joins pieces in pairs: those whose hull is near enough first, of these the one that fills the least volume beyond
// the two; then, while there are more than `most`, the one that is nearest to the solid.
void join(std::vector<Piece>& pieces, unsigned most, const Solid& solid) {
  struct Pair {
    std::size_t a, b;
    Piece both;
    double filled_m3, error_m;
  };
  const double rounding_m = kRoundingShare * solid.size_m;
  std::vector<Pair> pairs;
  std::vector<bool> gone(pieces.size(), false);
  const auto add_pairs_of = [&](std::size_t b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (gone[a] || !touch(pieces[a], pieces[b], rounding_m)) continue;
      auto both = joined(pieces[a], pieces[b], solid);
      if (!both) continue;
      const double filled = both->volume_m3 - pieces[a].volume_m3 - pieces[b].volume_m3;
      const double error = both->error_m(solid.tolerance_m);
      pairs.push_back({a, b, std::move(*both), filled, error});
    }
  };
  const auto is_better = [&](const Pair& p, const Pair& q) {
    const bool p_near = p.error_m <= solid.wanted_m, q_near = q.error_m <= solid.wanted_m;
    if (p_near != q_near) return p_near;
    return p_near ? p.filled_m3 < q.filled_m3 : p.error_m < q.error_m;
  };
  for (std::size_t b = 1; b < pieces.size(); ++b) add_pairs_of(b);
  for (std::size_t left = pieces.size(); !pairs.empty();) {
    const auto best = std::ranges::min_element(pairs, is_better);
    if (best->error_m > solid.wanted_m && left <= most) break;
    gone[best->a] = gone[best->b] = true;
    pieces.push_back(std::move(best->both));
    for (std::size_t i = 0; i + 1 < pieces.size(); ++i)
      if (!gone[i] && is_within(pieces[i], pieces.back(), kHullRounding * solid.size_m)) gone[i] = true;
    gone.push_back(false);
    left = static_cast<std::size_t>(std::ranges::count(gone, false));
    std::erase_if(pairs, [&](const Pair& p) { return gone[p.a] || gone[p.b]; });
    add_pairs_of(pieces.size() - 1);
  }
  std::vector<Piece> kept;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (!gone[i]) kept.push_back(std::move(pieces[i]));
  pieces = std::move(kept);
}

}  // namespace

Result<Pieces> decompose(const sim::TriangleSoup& soup, unsigned most, double deviation_m) {
  if (soup.triangles.size() > kMaxPieceTriangles)
    return Status::error(
        fmt::format("{} triangles are too many to divide, at most {}", soup.triangles.size(), kMaxPieceTriangles));
  if (soup.triangles.empty()) return Status::error("no triangles");
  const Solid solid{SolidDistance(soup), extent_of(soup.corners), deviation_m, kTolerance * deviation_m};
  std::vector<Piece> found = divided(soup, 2 * most, solid);
  join(found, most, solid);
  if (found.size() > most) return Status::error(fmt::format("takes {} pieces, more than {}", found.size(), most));
  Pieces pieces;
  for (const Piece& piece : found) {
    auto hull = hull_of(piece.surface.corners);
    if (!hull.ok()) {  // too thin for a hull: it is left out
      pieces.deviation_m = std::max(pieces.deviation_m, sim::kMinHullWidth_m);
      continue;
    }
    const Excess excess = measured(piece.surface, solid, kMaxDivisions);
    pieces.deviation_m =
        std::max(pieces.deviation_m, std::min(excess.bound_m, piece.excess.bound_m) + hull.value().deviation_m);
    pieces.hulls.push_back(std::move(hull).value());
  }
  if (pieces.hulls.empty()) return Status::error("every piece is too thin to be a hull");
  return pieces;
}

}  // namespace tactus::scene_import
