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
  // A deviation that is not required is at most a hundredth of the size, so that small things keep their hollows.
  const double wanted_m =
      options.required ? options.deviation_m : std::min(options.deviation_m, extent_of(soup.corners) / 100);
  auto pieces = decompose(soup, options.most, wanted_m);
  const char* const accepted = "more --pieces, a larger --deviation, or a model that is divided already";
  if (!pieces.ok()) return refuse(pieces.message(), accepted);
  const std::size_t count = pieces.value().hulls.size();
  const double deviation_m = pieces.value().deviation_m;
  if (options.required && deviation_m > wanted_m)
    return refuse(fmt::format("its {} pieces are up to {:.3g} mm from its surface, more than {:.3g} mm", count,
                              1e3 * deviation_m, 1e3 * wanted_m),
                  accepted);
  account.change(fmt::format("{}: divided into {} convex pieces, at most {:.3g} mm from its surface; {}", label, count,
                             1e3 * deviation_m,
                             deviation_m > wanted_m ? "more --pieces come nearer"
                                                    : "a smaller --deviation with enough --pieces comes nearer"));
  std::vector<DraftPart> parts;
  for (HullPoints& piece : pieces.value().hulls) parts.push_back(hull_part(like, std::move(piece.points)));
  return parts;
}

}  // namespace tactus::scene_import
