#include "tools/import/shape_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/text/nearest_word.h"
#include "tools/import/body_mass.h"
#include "tools/import/shape_nodes.h"

namespace tactus::scene_import {
namespace {

// The custom properties that an import uses.
struct Property {
  std::string_view name;
  double least;
  const char* accepted;
};
constexpr Property kProperties[] = {{"mass_kg", 1e-6, "a number, 1e-06 kg or more"},
                                    {"density_kg_per_m3", 1e-3, "a number, 0.001 kg/m3 or more"},
                                    {"friction", 0, "a number, 0 or more"},
                                    {"fixed", 0, "true or false, 1 or 0"}};
constexpr std::string_view kPropertyNames[] = {"mass_kg", "density_kg_per_m3", "friction", "fixed"};

class NodeTranslator {
 public:
  NodeTranslator(std::string file, const ShapeOptions& options, const PieceOptions& pieces, Account& account)
      : file_(std::move(file)), options_(options), pieces_(pieces), account_(account) {}

  void add(ShapeNode node, SceneDraft& draft) {
    const bool good = check_properties(node);
    for (Vec3d& corner : node.soup.corners) corner = corner * options_.unit_m;
    DraftBody body;
    body.name = node.name.empty() ? "shape" : node.name;
    body.origin = fmt::format("node \"{}\"", node.name);
    body.pose = {options_.unit_m * node.position, {}};
    body.friction = extra(node, "friction", options_.friction);
    const bool fixed = extra(node, "fixed", options_.fixed ? 1 : 0) != 0;
    const bool made = fixed ? set_fixed(std::move(node), body) : set_moving(node, body);
    if (made && good) draft.bodies.push_back(std::move(body));
  }

 private:
  static double extra(const ShapeNode& node, const char* key, double otherwise) {
    const auto found = node.extra.find(key);
    return found == node.extra.end() ? otherwise : found->second;
  }
  bool refuse(const DraftBody& body, std::string what, std::string accepted) {
    account_.refuse({.kind = "",
                     .file = file_,
                     .line = 0,
                     .what = fmt::format("{}: {}", body.origin, what),
                     .accepted = std::move(accepted)});
    return false;
  }

  // Lists unknown properties in the account: they belong to other programs. False if a known one is refused.
  bool check_properties(ShapeNode& node) {
    std::vector<std::string> bad;
    std::string others;
    for (const auto& [key, value] : node.extra) {
      const auto* const known = std::ranges::find(kProperties, key, &Property::name);
      if (known == std::end(kProperties)) {
        const auto nearest = text::nearest_word(key, kPropertyNames);
        others += fmt::format("{}{}{}", others.empty() ? "" : ", ", key,
                              nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest));
        continue;
      }
      if (std::isfinite(value) && value >= known->least) continue;
      account_.refuse({.kind = "",
                       .file = file_,
                       .line = 0,
                       .what = fmt::format("node \"{}\": {}: {}", node.name, key,
                                           std::isnan(value) ? "no number" : fmt::format("{:g}", value)),
                       .accepted = known->accepted});
      bad.push_back(key);
    }
    for (const std::string& key : bad) node.extra.erase(key);  // the other checks go on without them
    if (!others.empty())
      account_.left_out.push_back(fmt::format("custom properties of node \"{}\": {}", node.name, others));
    return bad.empty();
  }

  // Both: false where it is refused.
  bool set_fixed(ShapeNode node, DraftBody& body) {
    if (node.soup.triangles.size() > kMaxFixedTriangles)
      return refuse(body, fmt::format("{} triangles", node.soup.triangles.size()),
                    fmt::format("at most {}: make it coarser", kMaxFixedTriangles));
    body.role = DraftRole::kFixed;
    DraftPart part;
    part.shape = DraftShape::kMesh;
    part.pose = body.pose;
    part.mesh = std::move(node.soup);
    part.rounding = kSingleRounding;
    set_parts({std::move(part)}, {}, body);
    return true;
  }

  bool set_moving(const ShapeNode& node, DraftBody& body) {
    const MassProperties solid = solid_of(node.soup);
    const std::size_t open = open_edges(node.soup);
    if (open > 0)
      return refuse(body, fmt::format("its mesh is open at {} edges, and its mass comes from its volume", open),
                    "a closed surface, or a custom property fixed");
    if (!(solid.mass > 0)) return refuse(body, "its mesh has no volume, or is inside out", "a solid");
    const double density =
        extra(node, "mass_kg", extra(node, "density_kg_per_m3", options_.density_kg_per_m3) * solid.mass) / solid.mass;
    const MassProperties own{density * solid.mass, solid.centre, scaled(density, solid.inertia)};
    if (!is_a_body(own)) return refuse(body, fmt::format("a mass of {:g} kg", own.mass), "a mass above 0");
    DraftPart like;
    like.pose = body.pose;
    auto parts = mesh_parts(node.soup, pieces_, like, body.origin,
                            {.kind = "", .file = file_, .line = 0, .what = "", .accepted = ""}, account_);
    if (parts.empty()) return false;
    if (parts.size() > 1)
      account_.change(
          fmt::format("{}: {} shapes, one compound body; mass, centre and moments exact", body.origin, parts.size()));
    const Posed frame = body.pose;
    set_parts(std::move(parts), frame, body);
    set_mass(in_world(own, frame), body);
    return true;
  }

  const std::string file_;
  const ShapeOptions& options_;
  const PieceOptions& pieces_;
  Account& account_;
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
  return draft;
}

}  // namespace tactus::scene_import
