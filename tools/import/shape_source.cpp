#include "tools/import/shape_source.h"

#include <fmt/format.h>

#include "tools/import/pieces.h"
#include "tools/import/rigid_group.h"
#include "tools/import/shape_nodes.h"

namespace tactus::scene_import {
namespace {

constexpr std::size_t kMaxFixedTriangles = 20'000;

class NodeTranslator {
 public:
  NodeTranslator(std::string file, const ShapeOptions& options, const PieceOptions& pieces, Account& account)
      : file_(std::move(file)), options_(options), pieces_(pieces), account_(account) {}

  void add(ShapeNode node, SceneDraft& draft) {
    for (Vec3d& corner : node.soup.corners) corner = corner * options_.unit_m;
    DraftBody body;
    body.name = node.name.empty() ? "shape" : node.name;
    body.origin = fmt::format("node \"{}\"", node.name);
    body.pose = {options_.unit_m * node.position, {}};
    body.friction = extra(node, "friction", options_.friction);
    if (extra(node, "fixed", options_.fixed ? 1 : 0) != 0)
      add_fixed(std::move(node), std::move(body), draft);
    else
      add_moving(node, std::move(body), draft);
  }

  unsigned guards() const { return guards_; }

 private:
  static double extra(const ShapeNode& node, const char* key, double otherwise) {
    const auto found = node.extra.find(key);
    return found == node.extra.end() ? otherwise : found->second;
  }
  void refuse(const DraftBody& body, std::string what, std::string accepted) {
    account_.refuse({"", file_, 0, fmt::format("{}: {}", body.origin, what), std::move(accepted)});
  }

  void add_fixed(ShapeNode node, DraftBody body, SceneDraft& draft) {
    if (node.soup.triangles.size() > kMaxFixedTriangles)
      return refuse(body, fmt::format("{} triangles", node.soup.triangles.size()),
                    fmt::format("at most {}: make it coarser", kMaxFixedTriangles));
    body.role = DraftRole::kFixed;
    body.shape = DraftShape::kMesh;
    body.mesh = std::move(node.soup);
    draft.bodies.push_back(std::move(body));
  }

  void add_moving(const ShapeNode& node, DraftBody body, SceneDraft& draft) {
    const MassProperties solid = solid_of(node.soup);
    const std::size_t open = open_edges(node.soup);
    if (open > 0)
      return refuse(body, fmt::format("its mesh is open at {} edges, and its mass comes from its volume", open),
                    "a closed surface, or a custom property fixed");
    if (!(solid.mass > 0)) return refuse(body, "its mesh has no volume, or is inside out", "a solid");
    auto hull = hull_of(node.soup.corners);
    if (!hull.ok()) return refuse(body, hull.message(), "a solid");
    body.shape = DraftShape::kHull;
    RigidGroup group;
    group.label = body.origin;
    const double density =
        extra(node, "mass_kg", extra(node, "density_kg_per_m3", options_.density_kg_per_m3) * solid.mass) / solid.mass;
    group.whole = in_world({density * solid.mass, solid.centre, scaled(density, solid.inertia)}, body.pose);
    if (!add_shapes(node, std::move(hull).value(), std::move(body), group)) return;
    if (const std::string problem = group.settle(account_); !problem.empty())
      return account_.refuse({"", file_, 0, fmt::format("{}: {}", group.label, problem), "a solid of another form"});
    group.add_to(draft, guards_);
  }

  bool add_shapes(const ShapeNode& node, HullPoints hull, DraftBody body, RigidGroup& group) {
    if (hull.deviation_m > 0)
      account_.change(fmt::format("{}: its hull is thinned to {} vertices, at most {:.3g} mm from it", body.origin,
                                  hull.points.size(), 1e3 * hull.deviation_m));
    const auto gap = hull_gap(node.soup, hull);
    const bool concave = gap.ok() && gap.value() > hull.deviation_m + 1e-4;
    if (!concave || pieces_.most < 2) {
      if (concave)
        account_.change(
            fmt::format("{}: concave; its convex hull is taken, with gaps of up to {:.3g} mm; --pieces N "
                        "divides it",
                        body.origin, 1e3 * gap.value()));
      body.points = std::move(hull.points);
      group.parts.push_back({std::move(body), 1});
      return true;
    }
    auto pieces = decompose(node.soup, pieces_.most, pieces_.deviation_m);
    if (!pieces.ok()) {
      refuse(body, pieces.message(), "more --pieces, a larger --deviation, or a model that is divided already");
      return false;
    }
    account_.change(fmt::format("{}: divided into {} convex pieces, at most {:.3g} mm from its surface", body.origin,
                                pieces.value().hulls.size(), 1e3 * pieces.value().deviation_m));
    for (HullPoints& piece : pieces.value().hulls) {
      DraftBody part = body;
      if (!group.parts.empty()) part.name = fmt::format("{}.{}", body.name, group.parts.size() + 1);
      part.points = std::move(piece.points);
      group.parts.push_back({std::move(part), -1});
    }
    return true;
  }

  const std::string file_;
  const ShapeOptions& options_;
  const PieceOptions& pieces_;
  Account& account_;
  unsigned guards_{0};
};

}  // namespace

Result<SceneDraft> read_shapes(const std::filesystem::path& file, const ShapeOptions& options,
                               const PieceOptions& pieces, Account& account) {
  auto nodes = read_nodes(file);
  if (!nodes.ok()) return nodes.status();
  account.left_out = std::move(nodes.value().left_out);
  account.refused = std::move(nodes.value().refused);
  SceneDraft draft;
  draft.title = file.stem().string();
  draft.gravity = {0, 0, -9.81};
  NodeTranslator translator(file.filename().string(), options, pieces, account);
  for (ShapeNode& node : nodes.value().nodes) {
    if (node.name.empty()) node.name = fmt::format("shape_{}", draft.bodies.size() + 1);
    translator.add(std::move(node), draft);
  }
  if (draft.bodies.empty() && account.refused.empty())
    return Status::error(fmt::format("{}: no triangles; accepted: a file with solids", file.filename().string()));
  account.taken_over.push_back(fmt::format("mesh: {}", draft.bodies.size()));
  account.change(
      fmt::format("filled in: gravity, friction {} and a density of {} kg/m3 where a node says nothing (custom "
                  "properties friction, density_kg_per_m3, mass_kg, fixed)",
                  options.friction, options.density_kg_per_m3));
  if (translator.guards() > 0)
    account.change(fmt::format("{} pairs of bodies are kept from colliding by distance joints that do nothing else",
                               translator.guards()));
  return draft;
}

}  // namespace tactus::scene_import
