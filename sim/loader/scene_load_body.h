// Reads the table of one body of a scene file: its shape, mass and start. Thread: [setup]. Mistakes go to the reader's
// diagnostics; a wrong value is replaced by a harmless default.
#pragma once

#include <optional>

#include "rt/text/table_reader.h"
#include "sim/geometry/compound_builder.h"
#include "sim/loader/scene_load_hull.h"
#include "sim/loader/scene_load_mesh.h"

namespace tactus::sim {

enum class BodyRole { kProxy, kBody };

// A shape, and the pose of its frame in the frame of the body's keys: hulls, meshes and compounds are given in any
// frame.
struct ReadShape {
  physics::Shape shape;
  Posed given_from_body{};
  std::optional<HullOfBody> hull{};
};

struct ReadBody {
  physics::Body body;
  Posed given_from_body{};  // of the body's frame in that of its keys position_m and rotation
};

class BodyReader {
 public:
  // `folder`: file names are relative to it; none: no file is opened.
  BodyReader(Scene& scene, text::Diagnostics& diagnostics, const std::optional<std::filesystem::path>& folder)
      : scene_(scene),
        diagnostics_(diagnostics),
        hulls_(scene, diagnostics, folder),
        meshes_(scene, diagnostics, folder) {}

  // The [[hull_file]] and [[mesh_file]] tables of the text.
  void read_kept(text::TableReader& root);
  // The body has no id yet. Gravity does not act on the proxy: the device holds it.
  ReadBody read(text::TableReader& table, BodyRole role);
  // Text to append to the source, so that it needs no file.
  std::string kept() const { return hulls_.kept() + meshes_.kept(); }

 private:
  // Where a body's mass comes from: its own key, its parts' keys, or nowhere.
  enum class MassFrom { kNothing, kBody, kParts };

  std::optional<ReadShape> read_shape(text::TableReader& table, physics::ShapeKind kind);
  double volume_of(const physics::Shape& shape) const;
  Vec3d inertia_of(const physics::Shape& shape, double mass_kg) const;
  void read_mass_properties(text::TableReader& table, const ReadShape& known, ReadBody& read);
  void read_motion(text::TableReader& table, physics::Body& body);
  std::vector<GivenPart> read_parts(text::TableReader& table, MassFrom mass_from);
  void share_mass(text::TableReader& table, MassFrom mass_from, std::vector<GivenPart>& parts);
  physics::Shape add_compound(const BuiltCompound& built);
  ReadBody read_compound(text::TableReader& table, BodyRole role);

  Scene& scene_;
  text::Diagnostics& diagnostics_;
  HullReader hulls_;
  MeshReader meshes_;
};

}  // namespace tactus::sim
