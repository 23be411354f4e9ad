#include "tools/import/shape_nodes.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "sim/geometry/mesh_builder.h"
#include "tools/import/gltf_depth.h"
#include "tools/import/limited_process.h"
#include "tools/import/shape_source.h"
#include "tools/json_text.h"
#if TACTUS_HAS_ASSIMP
#include <assimp/DefaultIOSystem.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace tactus::scene_import {

#if TACTUS_HAS_ASSIMP

namespace {

using nlohmann::json;

constexpr Limits kLimits{.wall_s = 60, .cpu_s = 30, .memory_bytes = 2u << 30, .answer_bytes = 256u << 20};

// Opens files of one folder alone, for reading.
class FolderFiles : public Assimp::DefaultIOSystem {
 public:
  explicit FolderFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  bool Exists(const char* name) const override { return allowed(name); }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    return mode[0] == 'r' && allowed(name) ? DefaultIOSystem::Open(name, mode) : nullptr;
  }

 private:
  bool allowed(const char* name) const {
    std::error_code error;
    const auto real = std::filesystem::canonical(name, error);
    if (error || !std::filesystem::is_regular_file(real, error)) return false;
    const auto [end, rest] = std::mismatch(folder_.begin(), folder_.end(), real.begin(), real.end());
    return end == folder_.end() && std::filesystem::file_size(real, error) <= kMaxFileBytes && !error;
  }
  std::filesystem::path folder_;
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file) {
    const std::string ending = file.extension().string();
    y_up_ = ending == ".gltf" || ending == ".glb";
  }

  json read() {
    std::error_code error;
    const auto real = std::filesystem::canonical(file_, error);
    if (error) return {{"error", "cannot be read"}};
    if (const std::uintmax_t size = std::filesystem::file_size(real, error); error || size > kMaxFileBytes)
      return {{"error", fmt::format("has more than {} MB", kMaxFileBytes >> 20)}};
    if (y_up_)
      if (const std::string deep = gltf_depth_problem(real); !deep.empty()) return {{"error", deep}};
    Assimp::Importer importer;
    importer.SetIOHandler(new FolderFiles(real.parent_path()));  // the importer owns it
    const aiScene* scene = importer.ReadFile(real.string(), aiProcess_Triangulate);
    if (scene == nullptr || scene->mRootNode == nullptr) return {{"error", importer.GetErrorString()}};
    note(scene->mNumCameras, "cameras");
    note(scene->mNumLights, "lights");
    note(materials_of(*scene), "materials and textures");
    for (unsigned i = 0; i < scene->mNumAnimations; ++i)
      refuse(fmt::format("the animation \"{}\"", scene->mAnimations[i]->mName.C_Str()),
             "leave it out, or write it as a path of a kinematic body");
    visit(*scene, *scene->mRootNode, aiMatrix4x4(), 0);
    return {{"nodes", nodes_}, {"left_out", left_out_}, {"refused", refused_}, {"error", problem_}};
  }

 private:
  // Without the one that assimp makes up where a file has none.
  unsigned materials_of(const aiScene& scene) const {
    unsigned count = 0;
    for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
      const std::string name = scene.mMaterials[i]->GetName().C_Str();
      const bool of_gltf = y_up_ && i + 1 == scene.mNumMaterials && name.empty();
      if (!of_gltf && name != AI_DEFAULT_MATERIAL_NAME) ++count;
    }
    return count;
  }

  void note(unsigned count, const char* what) {
    if (count > 0) left_out_.push_back(fmt::format("{}: {}", what, count));
  }
  void refuse(const std::string& what, const char* accepted) {
    refused_.push_back({{"kind", "animations"}, {"what", what}, {"accepted", accepted}});
  }

  void visit(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent, unsigned depth) {
    if (depth > kMaxNodeDepth) problem_ = fmt::format("has nodes deeper than {}", kMaxNodeDepth);
    if (!problem_.empty()) return;
    const aiMatrix4x4 here = parent * node.mTransformation;
    if (node.mNumMeshes > 0) add(scene, node, here);
    for (unsigned i = 0; i < node.mNumChildren; ++i) visit(scene, *node.mChildren[i], here, depth + 1);
  }

  Vec3d place(const aiVector3D& v) const {
    const auto x = static_cast<double>(v.x);
    const auto y = static_cast<double>(v.y);
    const auto z = static_cast<double>(v.z);
    return y_up_ ? Vec3d{x, -z, y} : Vec3d{x, y, z};
  }

  void add(const aiScene& scene, const aiNode& node, const aiMatrix4x4& here) {
    std::vector<double> corners;
    std::vector<std::uint32_t> triangles;
    const Vec3d origin = place(here * aiVector3D());
    const bool mirrored = here.Determinant() < 0;  // then its triangles go the other way round
    for (unsigned m = 0; m < node.mNumMeshes; ++m) {
      const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
      if (mesh.mNumBones > 0)
        refuse(fmt::format("the node \"{}\" has a skin", node.mName.C_Str()), "bodies here are rigid: a mesh without");
      if (mesh.mNumAnimMeshes > 0)
        refuse(fmt::format("the node \"{}\" has morph targets", node.mName.C_Str()), "a mesh without");
      const auto first = static_cast<std::uint32_t>(corners.size() / 3);
      for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        const Vec3d v = place(here * mesh.mVertices[i]) - origin;
        corners.insert(corners.end(), {v.x, v.y, v.z});
      }
      for (unsigned i = 0; i < mesh.mNumFaces; ++i)
        if (mesh.mFaces[i].mNumIndices == 3)
          for (unsigned k = 0; k < 3; ++k) triangles.push_back(first + mesh.mFaces[i].mIndices[mirrored ? 2 - k : k]);
    }
    triangles_ += triangles.size() / 3;
    if (nodes_.size() >= kMaxShapeNodes || triangles_ > kMaxShapeTriangles)
      problem_ = fmt::format("has more than {} nodes or {} triangles", kMaxShapeNodes, kMaxShapeTriangles);
    if (triangles.empty() || !problem_.empty()) return;
    nodes_.push_back({{"name", node.mName.C_Str()},
                      {"position", {origin.x, origin.y, origin.z}},
                      {"corners", corners},
                      {"triangles", triangles},
                      {"extra", extra_of(node)}});
  }

  // Custom properties; one that is no number is null.
  static json extra_of(const aiNode& node) {
    json extra = json::object();
    if (node.mMetaData != nullptr) collect(*node.mMetaData, extra);
    return extra;
  }

  static void collect(const aiMetadata& data, json& extra) {
    for (unsigned i = 0; i < data.mNumProperties; ++i) {
      const aiMetadataEntry& entry = data.mValues[i];
      const char* key = data.mKeys[i].C_Str();
      if (entry.mType != AI_AIMETADATA) extra[key] = nullptr;
      if (entry.mType == AI_BOOL) extra[key] = *static_cast<bool*>(entry.mData) ? 1.0 : 0.0;
      if (entry.mType == AI_INT32) extra[key] = *static_cast<std::int32_t*>(entry.mData);
      if (entry.mType == AI_UINT64) extra[key] = *static_cast<std::uint64_t*>(entry.mData);
      if (entry.mType == AI_FLOAT) extra[key] = static_cast<double>(*static_cast<float*>(entry.mData));
      if (entry.mType == AI_DOUBLE) extra[key] = *static_cast<double*>(entry.mData);
      if (entry.mType == AI_AIMETADATA) collect(*static_cast<aiMetadata*>(entry.mData), extra);
    }
  }

  const std::filesystem::path file_;
  bool y_up_{false};
  json nodes_ = json::array(), refused_ = json::array(), left_out_ = json::array();
  std::string problem_;
  std::size_t triangles_{0};
};

ShapeNode node_of(const json& object) {
  ShapeNode node;
  node.name = object.at("name");
  const auto& p = object.at("position");
  node.position = {p.at(0), p.at(1), p.at(2)};
  const auto corners = object.at("corners").get<std::vector<double>>();
  const auto triangles = object.at("triangles").get<std::vector<std::uint32_t>>();
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    node.soup.corners.push_back({corners[i], corners[i + 1], corners[i + 2]});
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
    node.soup.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
  node.soup = sim::weld(node.soup);
  for (const auto& [key, value] : object.at("extra").items())
    node.extra[key] = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  return node;
}

}  // namespace

Result<ShapeNodes> read_nodes(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  auto text = run_apart([&file] { return json_text(Reader(file).read()); }, kLimits);
  if (!text.ok()) return Status::error(fmt::format("{}: {}", name, text.message()));
  try {
    const json answer = json::parse(text.value());
    if (const std::string problem = answer.at("error"); !problem.empty())
      return Status::error(fmt::format("{}: {}; accepted: a file that assimp reads", name, problem));
    ShapeNodes out;
    // What is not finite has no number in JSON, and is an exception here.
    for (const json& object : answer.at("nodes")) out.nodes.push_back(node_of(object));
    for (const json& text_of_it : answer.at("left_out")) out.left_out.push_back(text_of_it);
    for (const json& r : answer.at("refused"))
      out.refused.push_back(
          {.kind = r.at("kind"), .file = name, .line = 0, .what = r.at("what"), .accepted = r.at("accepted")});
    return out;
  } catch (const json::exception&) {
    return Status::error(fmt::format("{}: a corner or a property is no finite number; accepted: finite numbers", name));
  }
}

#else

Result<ShapeNodes> read_nodes(const std::filesystem::path& file) {
  return Status::error(fmt::format("{}: this build reads no shapes: assimp was missing (Debian: libassimp-dev)",
                                   file.filename().string()));
}

#endif

}  // namespace tactus::scene_import
