// A scene from a file of another program: MJCF, URDF (MuJoCo's compiler, in Node), glTF, OBJ, STL (assimp).
//
// Thread: the only one of the program. Bound: those of the readers. Errors: one line, without an
// account; all else that is refused is in the account, and no scene is made.
#pragma once

#include "tools/import/limited_process.h"
#include "tools/import/shape_source.h"

namespace tactus::scene_import {

// Of a concave mesh of a glTF, OBJ or STL file, where the user gives no number.
inline constexpr unsigned kDefaultPieces = 64;

struct ImportOptions {
  std::filesystem::path file, compiler;  // compiler: compile.mjs as installed
  std::string stem;                      // prefix of the names of shape files
  std::vector<std::string> drop;
  std::string proxy;  // a body's name, or a radius in m; empty: a sphere of 1 cm
  std::optional<Vec3d> proxy_position;
  std::string device{"virtuose6d"};
  PieceOptions pieces;
  bool needs_deviation{false};  // a larger deviation than that of `pieces` is refused, also without a number of pieces
  ShapeOptions shapes;
  Limits compiler_limits{};  // of the compiler's process
};

struct Imported {
  SceneFiles files;  // empty where something is refused
  Account account;
};

// An error of the file or, if `machine_lacks`, of a machine that lacks a program or a library.
struct ImportError {
  std::string message;
  bool machine_lacks{false};
};
std::optional<ImportError> import_file(const ImportOptions& options, Imported& imported);

}  // namespace tactus::scene_import
