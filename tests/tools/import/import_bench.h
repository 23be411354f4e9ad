// Imports of the models in tests/tools/import/models, and the scenes that they make, for the tests.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "rt/physics/body.h"
#include "sim/loader/scene_load.h"
#include "tests/support/skip.h"
#include "tools/import/import.h"
#include "tools/import/mass_properties.h"

namespace tactus::test {

inline const std::filesystem::path kModels = TACTUS_SOURCE_DIR "/tests/tools/import/models";

// compile.mjs beside the wasm, where node and npm were there when this was built.
inline std::filesystem::path compiler() {
  return std::filesystem::path(TACTUS_PROGRAM).parent_path().parent_path() / "share/tactus/import/compile.mjs";
}

constexpr bool kHasAssimp = TACTUS_TEST_HAS_ASSIMP != 0;
#define TACTUS_NEEDS_ASSIMP() TACTUS_NEEDS(tactus::test::kHasAssimp, "no assimp in this build (Debian: libassimp-dev)")

constexpr double kPi = 3.141592653589793;

inline bool has_compiler() {
  std::error_code none;
  return std::filesystem::exists(compiler().parent_path() / "mujoco.wasm", none) &&
         std::system("node --version > /dev/null 2>&1") == 0;
}

#define TACTUS_NEEDS_COMPILER() \
  TACTUS_NEEDS(has_compiler(), "no MuJoCo: node and npm are missing (Debian: nodejs, npm)")

// A folder of its own, gone at the end of the test.
struct Scratch {
  Scratch() {
    std::string name = std::filesystem::temp_directory_path() / "tactus_import_XXXXXX";
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Scratch() { std::filesystem::remove_all(path); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name, std::ios::binary) << text;
    return path / name;
  }
  std::filesystem::path path;
};

inline scene_import::ImportOptions options_for(const std::filesystem::path& file) {
  scene_import::ImportOptions options;
  options.file = file;
  options.compiler = compiler();
  options.stem = "made";
  return options;
}

// An import that must work.
inline scene_import::Imported imported(const scene_import::ImportOptions& options) {
  scene_import::Imported made;
  const auto error = scene_import::import_file(options, made);
  INFO((error ? error->message : scene_import::lines_of(made.account.refused)));
  REQUIRE_FALSE(error);
  REQUIRE(made.account.refused.empty());
  return made;
}

inline scene_import::Imported imported(const std::string& name) { return imported(options_for(kModels / name)); }

// The reason why a file is refused: the error, or the account's lines.
inline std::string refusal(const scene_import::ImportOptions& options) {
  scene_import::Imported made;
  if (const auto error = scene_import::import_file(options, made)) return error->message;
  CHECK(made.files.text.empty());
  return scene_import::lines_of(made.account.refused);
}

inline std::filesystem::path written(const scene_import::Imported& made, const Scratch& scratch) {
  for (const auto& [name, text] : made.files.shapes) scratch.write(name, text);
  return scratch.write("made.toml", made.files.text);
}

inline sim::Scene loaded(const scene_import::Imported& made) {
  const Scratch scratch;
  auto scene = sim::load_scene(written(made, scratch));
  INFO(scene.message() << "\n" << made.files.text);
  REQUIRE(scene.ok());
  return std::move(scene).value();
}

inline scene_import::MassProperties mass_of(const physics::Body& body) {
  return scene_import::principal_mass(body.mass, body.motion.pose.position, body.motion.pose.rotation, body.inertia);
}

}  // namespace tactus::test
