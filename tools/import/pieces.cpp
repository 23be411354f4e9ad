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

constexpr double kRoundingShare = 1e-9;      // of the size: the rounding of a cut
constexpr unsigned kDivisions = 4'000;       // of a surface that is measured for a choice
constexpr double kTolerance = 1.0 / 8;       // of the deviation that is wanted, likewise
constexpr double kLastTolerance = 1.0 / 50;  // of the deviation that is wanted, in the measure of the result

struct Solid {
  SolidDistance distance;
  double size_m, wanted_m;
};

struct Piece {
  Fragment fragment;          // empty of a joined piece
  sim::TriangleSoup surface;  // of its hull
  double volume_m3{0};
  Excess excess;
  double thinning_m{0};  // by how much 64 vertices are less than its hull
  bool final{false};     // no plane divides it
  double error_m() const { return excess.bound_m + thinning_m; }
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
Excess measured(const sim::TriangleSoup& hull, const Solid& solid, double share, unsigned divisions) {
  Vec3d middle;
  for (const Vec3d& corner : hull.corners) middle += corner * (1.0 / static_cast<double>(hull.corners.size()));
  sim::TriangleSoup all;
  for (const double scale : {1.0, 2.0 / 3, 1.0 / 3}) {
    const auto first = static_cast<std::uint32_t>(all.corners.size());
    for (const Vec3d& corner : hull.corners) all.corners.push_back(middle + scale * (corner - middle));
    for (const auto& t : hull.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return excess_of(all, solid.distance, share * solid.wanted_m, divisions);
}

// Measures the piece; the thinning only of one that is near enough otherwise.
void measure(Piece& piece, const Solid& solid) {
  piece.excess = measured(piece.surface, solid, kTolerance, kDivisions);
  piece.thinning_m = 0;
  if (piece.surface.corners.size() <= physics::kMaxHullVertices || piece.excess.bound_m > solid.wanted_m) return;
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

// The two parts of the piece with the least volume together; none where no plane leaves two solids.
std::optional<std::pair<Piece, Piece>> halves_of(const Piece& piece, const Solid& solid) {
  std::optional<std::pair<Piece, Piece>> best;
  const double rounding_m = kRoundingShare * solid.size_m;
  for (const Plane& plane : planes_to_try(piece.fragment, piece.excess.at, rounding_m)) {
    Cut parts = cut(piece.fragment, plane, solid.distance, rounding_m);
    if (parts.below.triangles.empty() || parts.above.triangles.empty()) continue;
    auto below = piece_of(std::move(parts.below)), above = piece_of(std::move(parts.above));
    if (!below || !above) continue;
    if (!best || below->volume_m3 + above->volume_m3 < best->first.volume_m3 + best->second.volume_m3)
      best.emplace(std::move(*below), std::move(*above));
  }
  return best;
}

std::vector<Piece> divided(const sim::TriangleSoup& soup, unsigned most, const Solid& solid) {
  std::vector<Piece> pieces;
  if (auto whole = piece_of(whole_of(soup))) {
    measure(*whole, solid);
    pieces.push_back(std::move(*whole));
  }
  while (!pieces.empty() && pieces.size() < most) {
    const auto worst =
        std::ranges::max_element(pieces, {}, [](const Piece& p) { return p.final ? -1.0 : p.error_m(); });
    if (worst->final || worst->error_m() <= solid.wanted_m) break;
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
  for (int k = 0; k < 3; ++k) {
    const auto along = [k](const Vec3d& p) { return p[k]; };
    const auto [low_a, high_a] = std::ranges::minmax(a.surface.corners, {}, along);
    const auto [low_b, high_b] = std::ranges::minmax(b.surface.corners, {}, along);
    if (low_a[k] > high_b[k] + rounding_m || low_b[k] > high_a[k] + rounding_m) return false;
  }
  return true;
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

// Joins the two pieces whose hull is nearest to the solid, as long as it is near enough or there are more than `most`.
void join(std::vector<Piece>& pieces, unsigned most, const Solid& solid) {
  struct Pair {
    std::size_t a, b;
    Piece both;
  };
  std::vector<Pair> pairs;
  std::vector<bool> gone(pieces.size(), false);
  const auto add_pairs_of = [&](std::size_t b, std::size_t upto) {
    for (std::size_t a = 0; a < upto; ++a)
      if (!gone[a] && touch(pieces[a], pieces[b], kRoundingShare * solid.size_m))
        if (auto both = joined(pieces[a], pieces[b], solid)) pairs.push_back({a, b, std::move(*both)});
  };
  for (std::size_t b = 1; b < pieces.size(); ++b) add_pairs_of(b, b);
  for (std::size_t left = pieces.size(); !pairs.empty(); --left) {
    const auto best = std::ranges::min_element(pairs, {}, [](const Pair& p) { return p.both.error_m(); });
    if (best->both.error_m() > solid.wanted_m && left <= most) break;
    const std::size_t a = best->a, b = best->b;
    pieces.push_back(std::move(best->both));
    gone.push_back(false);
    gone[a] = gone[b] = true;
    std::erase_if(pairs, [&](const Pair& p) { return gone[p.a] || gone[p.b]; });
    add_pairs_of(pieces.size() - 1, pieces.size() - 1);
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
  const Solid solid{SolidDistance(soup), extent_of(soup.corners), deviation_m};
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
    const Excess excess = measured(piece.surface, solid, kLastTolerance, kMaxDivisions);
    pieces.deviation_m =
        std::max(pieces.deviation_m, std::min(excess.bound_m, piece.excess.bound_m) + hull.value().deviation_m);
    pieces.hulls.push_back(std::move(hull).value());
  }
  if (pieces.hulls.empty()) return Status::error("every piece is too thin to be a hull");
  return pieces;
}

}  // namespace tactus::scene_import
