// Reads the triangle meshes of a scene file, from files of triangles beside it.
//
// A file's triangles are stored at the end of the scene's source as [[mesh_file]] tables, as hulls are, so that a tape
// replays without the file.
// Thread: [setup]. Mistakes go to the reader's diagnostics. Bound: kMaxMeshTriangles and kMaxMeshCorners over all
// meshes of the scene; each body with a mesh counts.
#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include "rt/text/table_reader.h"
#include "sim/geometry/mesh_builder.h"
#include "sim/model/scene.h"

namespace tactus::sim {

struct MeshOfBody {
  std::uint32_t index{0};  // into the scene's meshes
  Posed given_from_body;
};

class MeshReader {
 public:
  // `folder`: file names are relative to it; none: no file is opened.
  MeshReader(Scene& scene, text::Diagnostics& diagnostics, std::optional<std::filesystem::path> folder)
      : scene_(scene), diagnostics_(diagnostics), folder_(std::move(folder)) {}

  // The [[mesh_file]] tables of the text.
  void read_kept(std::span<const text::TomlNode> tables);

  // Builds the mesh from a body's file and file_unit_m. If that fails: empty, and a mistake.
  std::optional<MeshOfBody> read(text::TableReader& body);

  const physics::Mesh& mesh(std::uint32_t index) const { return scene_.meshes[index]; }
  // Text to append to the source, so that it needs no file.
  const std::string& kept() const { return kept_; }

 private:
  using FileKey = std::pair<std::string, double>;  // name, unit in metres
  struct Given {
    TriangleSoup soup;  // welded, in m
    unsigned welded{0};
  };

  const Given* find(text::TableReader& body, const FileKey& key);
  std::optional<MeshOfBody> add(text::TableReader& body, const std::string& file, const Given& given);

  Scene& scene_;
  text::Diagnostics& diagnostics_;
  std::optional<std::filesystem::path> folder_;
  std::map<FileKey, Given> given_;
  std::string kept_;
  std::size_t corners_{0}, triangles_{0};  // totals of all meshes
  BodyId next_patch_{physics::kFirstPatchId};
};

}  // namespace tactus::sim
