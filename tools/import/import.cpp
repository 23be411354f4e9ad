#include "tools/import/import.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "rt/base/ids.h"
#include "tools/import/check_scene.h"
#include "tools/import/model_to_draft.h"

namespace tactus::scene_import {
namespace {

constexpr double kLeastRadius_m = 1e-4, kLargestRadius_m = 10;

bool is_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access((folder + "/" + name).c_str(), X_OK) == 0) return true;
  return false;
}

std::optional<ImportError> read_model(const ImportOptions& options, Imported& imported, SceneDraft& draft) {
  const std::string name = options.file.filename().string();
  std::error_code none;
  if (!std::filesystem::exists(options.compiler.parent_path() / "mujoco.wasm", none))
    return ImportError{fmt::format("{}: MJCF and URDF need MuJoCo's compiler, which this build lacks: it was built "
                                   "without node and npm (Debian: nodejs, npm)",
                                   name),
                       true};
  if (!is_program("node"))
    return ImportError{fmt::format("{}: MJCF and URDF need the program node (Debian: nodejs)", name), true};
  const auto model = compile_model(options.compiler, options.file, options.compiler_limits, imported.account);
  if (model.ok()) {
    draft = draft_of(model.value(), options.pieces, imported.account);
    if (draft.title.empty()) draft.title = options.file.stem().string();
    return {};
  }
  // Refused elements may be the reason why the model does not compile: reports both.
  if (imported.account.refused.empty()) return ImportError{model.message()};
  const bool lacks_files = std::ranges::count(imported.account.refused, "files", &Refusal::kind) > 0;
  if (lacks_files && model.message().find("Error opening file") != std::string::npos) return {};
  const std::size_t accepted = model.message().rfind("; accepted: ");
  const std::string what = model.message().substr(0, accepted);
  imported.account.refuse({.kind = "",
                           .file = name,
                           .line = 0,
                           .what = what.starts_with(name + ": ") ? what.substr(name.size() + 2) : what,
                           .accepted = "a model that MuJoCo compiles"});
  return {};
}

std::optional<ImportError> choose_proxy(const ImportOptions& options, SceneDraft& draft) {
  draft.proxy.device = options.device;
  draft.proxy.position = options.proxy_position;
  if (const auto& p = options.proxy_position; p && !(std::isfinite(p->x) && std::isfinite(p->y) && std::isfinite(p->z)))
    return ImportError{"--proxy-position: not finite; accepted: three finite numbers [m]"};
  if (options.proxy.empty()) return {};
  const char* end = options.proxy.data() + options.proxy.size();
  double radius = 0;
  const auto [read_to, error] = std::from_chars(options.proxy.data(), end, radius);
  if (error == std::errc() && read_to == end) {
    if (!(radius >= kLeastRadius_m && radius <= kLargestRadius_m))
      return ImportError{
          fmt::format("--proxy {}: no radius; accepted: {} to {} m", options.proxy, kLeastRadius_m, kLargestRadius_m)};
    draft.proxy.radius_m = radius;
    return {};
  }
  std::string names;
  for (std::size_t i = 0; i < draft.bodies.size(); ++i) {
    const DraftBody& body = draft.bodies[i];
    if (body.role != DraftRole::kMoving) continue;
    if (body.name == options.proxy) {
      draft.proxy.body = i;
      return {};
    }
    if (names.size() < 200) names += (names.empty() ? "" : ", ") + body.name;
  }
  return ImportError{fmt::format("--proxy {}: no moving body has this name; accepted: a radius in m, or {}",
                                 options.proxy, names.empty() ? "nothing else" : names)};
}

// For a model with refused elements: adds what the loader refuses of the other elements.
std::optional<ImportError> refuse_more(const SceneDraft& draft, const std::string& name, Account& account) {
  if (draft.bodies.empty()) return {};
  Account of_draft;
  const SceneFiles files = write_scene(draft, "shape", of_draft);
  if (const Status status = check_scene(files, name, CheckScope::kElements, account); !status.ok())
    return ImportError{fmt::format("{}: {}", name, status.message()), true};
  return {};
}

}  // namespace

std::optional<ImportError> import_file(const ImportOptions& options, Imported& imported) {
  Account& account = imported.account;
  SceneDraft draft;
  std::string ending = options.file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::string name = options.file.filename().string();
  std::error_code none;
  const char* source = "MuJoCo's compiler";
  if (ending == ".sdf" || ending == ".usd" || ending == ".usda" || ending == ".usdc" || ending == ".usdz")
    return ImportError{fmt::format("{}: {} is not read; accepted: MJCF, URDF, glTF, OBJ, STL", name,
                                   ending == ".sdf" ? "SDF" : "USD")};
  if (!std::filesystem::is_regular_file(options.file, none))
    return ImportError{fmt::format("{}: no such file; accepted: MJCF, URDF, glTF, OBJ, STL", options.file.string())};
  if (ending == ".xml" || ending == ".mjcf" || ending == ".urdf") {
    if (auto error = read_model(options, imported, draft)) return error;
  } else if (ending == ".gltf" || ending == ".glb" || ending == ".obj" || ending == ".stl") {
    source = "assimp";
    PieceOptions pieces = options.pieces;
    if (pieces.most == 0)
      pieces = {options.needs_deviation ? kMaxParts : kDefaultPieces, pieces.deviation_m, options.needs_deviation};
    auto read = read_shapes(options.file, options.shapes, pieces, account);
    if (!read.ok()) return ImportError{read.message(), read.message().find("this build") != std::string::npos};
    draft = std::move(read).value();
  } else {
    return ImportError{
        fmt::format("{}: no kind that is known; accepted: .xml, .mjcf (MJCF), .urdf, .gltf, .glb, .obj, .stl", name)};
  }
  drop(options.drop, account);
  make_names_unique(draft);
  if (!account.refused.empty()) return refuse_more(draft, name, account);
  if (auto error = choose_proxy(options, draft)) return error;
  draft.head.push_back(fmt::format("Made by tactus import from {}, by {}.", name, source));
  for (const std::string& text : account.dropped) draft.head.push_back("Left out by --drop: " + text);
  SceneFiles files = write_scene(draft, options.stem, account);
  if (const Status status = check_scene(files, name, CheckScope::kWhole, account); !status.ok())
    return ImportError{fmt::format("{}: {}", name, status.message()), true};
  if (account.refused.empty()) imported.files = std::move(files);
  return {};
}

}  // namespace tactus::scene_import
