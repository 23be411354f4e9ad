// A model as MuJoCo's compiler gives it: what tools/import/compiler prints.
//
// Units: SI, rad. Frame: world, at the model's start. Thread: any normal one. Bound: that of the compiler's process
// (time, memory, size of the answer). Errors: one line; what a scene cannot have goes to the account, all of it in one
// go.
#pragma once

#include <filesystem>

#include "rt/base/result.h"
#include "sim/geometry/mesh_files.h"
#include "tools/import/account.h"
#include "tools/import/limited_process.h"
#include "tools/import/mass_properties.h"

namespace tactus::scene_import {

struct Place {
  std::string name, file;
  unsigned line{0};
};

struct ModelBody : Place {
  int parent{0}, weld{0};  // weld: first body of the group that is connected without joints; 0: the world
  bool mocap{false}, explicit_inertia{false};
  Posed pose;
  MassProperties mass;
  Twistd velocity;  // of the centre of mass
};

struct ModelGeom : Place {
  int body{0};
  std::string type;  // plane, hfield, sphere, capsule, ellipsoid, cylinder, box, mesh
  Vec3d size;        // as MuJoCo has it: half lengths, radii
  Posed pose;
  bool touches{false};  // contype or conaffinity is not 0
  int condim{3};
  Vec3d friction;           // sliding, torsional [m], rolling [m]
  int mesh{-1}, field{-1};  // index of its mesh, of its height field
};

struct ModelJoint : Place {
  std::string type;  // free, ball, slide, hinge
  int body{0}, parent{0};
  Vec3d anchor, axis;
  bool limited{false};
  double low{0}, high{0}, coordinate{0};  // of the coordinate at the start
};

struct ModelEquality : Place {
  std::string type;  // connect, weld
  bool active{true};
  int body_a{-1}, body_b{-1};
  Vec3d anchor;
  double error{0};  // m or rad: how far the start is from satisfying it
};

struct ModelMesh : Place {
  sim::TriangleSoup soup;  // welded
};

struct HeightField {
  std::string name;
  unsigned rows{0}, columns{0};
  double half_x{0}, half_y{0}, height{0};  // m
  std::vector<double> heights;             // 0 to 1, by rows of ascending y
};

struct CompiledModel {
  bool urdf{false};
  std::string name;
  std::vector<ModelBody> bodies;  // the first is the world
  std::vector<ModelGeom> geoms;
  std::vector<ModelJoint> joints;
  std::vector<ModelEquality> equalities;
  std::vector<ModelMesh> meshes;
  std::vector<HeightField> fields;
  std::vector<std::pair<int, int>> excluded;  // bodies that do not collide
  Vec3d gravity;
  bool parents_filtered{true}, limits{true}, equality_rows{true};
};

// Runs the compiler, `program`: compile.mjs, beside its wasm. Refusals and what is left out go to `account`; where the
// model could be compiled, it is returned even then, so that the caller can find more. `limits`: of the compiler.
Result<CompiledModel> compile_model(const std::filesystem::path& program, const std::filesystem::path& file,
                                    const Limits& limits, Account& account);

}  // namespace tactus::scene_import
