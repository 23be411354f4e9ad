#include "tools/import/mesh_parts.h"

#include <fmt/format.h>

namespace tactus::scene_import {
namespace {

constexpr double kConcave_m = 1e-4;  // a gap that counts

DraftPart hull_part(DraftPart part, std::vector<Vec3d> points) {
  part.shape = DraftShape::kHull;
  part.points = std::move(points);
  part.rounding = kSingleRounding;
  return part;
}

}  // namespace

std::vector<DraftPart> mesh_parts(const sim::TriangleSoup& soup, const PieceOptions& options, const DraftPart& like,
                                  const std::string& label, Refusal at, Account& account) {
  const auto refuse = [&](const std::string& what, const char* accepted) {
    at.what = fmt::format("{}: {}", label, what);
    at.accepted = accepted;
    account.refuse(at);
    return std::vector<DraftPart>();
  };
  auto hull = hull_of(soup.corners);
  if (!hull.ok()) return refuse(hull.message(), "a solid");
  const auto gap = hull_gap(soup, hull.value());
  const bool concave = gap.ok() && gap.value() > hull.value().deviation_m + kConcave_m;
  if (!concave || options.most < 2) {
    if (hull.value().deviation_m > 0)
      account.change(fmt::format("{}: its hull is thinned to {} vertices, at most {:.3g} mm from it", label,
                                 hull.value().points.size(), 1e3 * hull.value().deviation_m));
    if (concave)
      account.change(
          fmt::format("{}: concave; its convex hull is taken, with gaps of up to {:.3g} mm; --pieces N divides it",
                      label, 1e3 * gap.value()));
    return {hull_part(like, std::move(hull.value().points))};
  }
  auto pieces = decompose(soup, options.most, options.deviation_m);
  if (!pieces.ok())
    return refuse(pieces.message(), "more --pieces, a larger --deviation, or a model that is divided already");
  account.change(fmt::format("{}: divided into {} convex pieces, at most {:.3g} mm from its surface", label,
                             pieces.value().hulls.size(), 1e3 * pieces.value().deviation_m));
  std::vector<DraftPart> parts;
  for (HullPoints& piece : pieces.value().hulls) parts.push_back(hull_part(like, std::move(piece.points)));
  return parts;
}

}  // namespace tactus::scene_import
