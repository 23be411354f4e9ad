// tactus import FILE -o SCENE: a scene from MJCF, URDF, glTF, OBJ or STL, and an account of what became of it.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "rt/base/ids.h"
#include "tools/experiment/shared_files.h"
#include "tools/import/import.h"
#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

using nlohmann::ordered_json;
using scene_import::Account;

struct ImportCommand {
  std::string file, out;
  std::vector<double> proxy_position;
  double deviation_mm{1};
  bool overwrite{false}, json{false};
  scene_import::ImportOptions options;
};

ordered_json to_json(const Account& account) {
  ordered_json refused = ordered_json::array();
  for (const auto& r : account.refused)
    refused.push_back(
        {{"kind", r.kind}, {"file", r.file}, {"line", r.line}, {"what", r.what}, {"accepted", r.accepted}});
  return {{"bodies", account.bodies},   {"joints", account.joints},     {"taken_over", account.taken_over},
          {"changed", account.changed}, {"left_out", account.left_out}, {"refused", refused}};
}

int fail(const std::string& text, int exit_code) { return complain("tactus import: " + text, exit_code); }

int write_all(const ImportCommand& command, const scene_import::SceneFiles& files) {
  const std::filesystem::path folder = std::filesystem::path(command.out).parent_path();
  if (!command.overwrite) {
    std::vector<std::string> paths{command.out};
    for (const auto& shape : files.shapes) paths.push_back((folder / shape.first).string());
    std::error_code none;
    for (const std::string& path : paths)
      if (std::filesystem::exists(path, none))
        return fail(path + ": exists; accepted: another name, or --overwrite", kExitBadInput);
  }
  for (const auto& [name, text] : files.shapes)
    if (const int status = write_file((folder / name).string(), text); status != kExitGood) return status;
  return write_file(command.out, files.text);
}

int run_import(ImportCommand& command) {
  auto& options = command.options;
  const std::filesystem::path out = command.out;
  if (out.extension() != ".toml")
    return fail(command.out + ": no name of a scene; accepted: -o NAME.toml", kExitBadInput);
  options.file = command.file;
  options.stem = out.stem().string();
  options.compiler = experiment::shared_file("import/compile.mjs");
  options.pieces.deviation_m = 1e-3 * command.deviation_mm;
  if (command.proxy_position.size() == 3)
    options.proxy_position = Vec3d{command.proxy_position[0], command.proxy_position[1], command.proxy_position[2]};
  scene_import::Imported imported;
  if (const auto error = scene_import::import_file(options, imported))
    return fail(error->message, error->machine_lacks ? kExitMachineCannot : kExitBadInput);
  const Account& account = imported.account;
  if (!account.refused.empty()) {
    const std::string lines = scene_import::lines_of(account.refused);
    ordered_json object = to_json(account);
    object["error"] = lines;
    object["exit_code"] = kExitBadInput;
    if (command.json) fmt::print("{}\n", report_text(object, 2));
    fmt::print(stderr, "tactus import: {} {} refused\n{}\n", account.refused.size(),
               account.refused.size() == 1 ? "thing is" : "things are", lines);
    return kExitBadInput;
  }
  if (const int status = write_all(command, imported.files); status != kExitGood) return status;
  if (command.json)
    fmt::print("{}\n", report_text(to_json(account), 2));
  else
    fmt::print("{}: {}\n", command.out, scene_import::text_of(account));
  return kExitGood;
}

}  // namespace

CLI::App* add_import_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<ImportCommand>();
  auto& options = command->options;
  CLI::App* app = program.add_subcommand("import", "Convert a model in MJCF, URDF, glTF, OBJ or STL to a scene.");
  app->footer(
      "MJCF and URDF are read by MuJoCo's own compiler, which Node runs: masses, frames and defaults are MuJoCo's.\n"
      "The result lists what was converted, what was changed and by how much, and what was left out. A model with\n"
      "something that a scene cannot have is refused: every such item is reported with file, line and what to do,\n"
      "and nothing is written. No file outside of FILE's folder is read.\n"
      "Exit status: 0 good; 2 something is refused, bad usage or file; 3 no node, or a build without the reader.\n\n"
      "Examples:\n"
      "  tactus import gripper.xml -o gripper.toml && tactus scene check gripper.toml\n"
      "  tactus import arm.urdf -o arm.toml --drop damping,friction-loss --proxy tool\n"
      "  tactus import bracket.stl -o bracket.toml --unit 0.001 --pieces 16 --deviation 0.5");
  app->add_option("FILE", command->file, "model file: .xml or .mjcf (MJCF), .urdf, .gltf, .glb, .obj, .stl")
      ->required();
  app->add_option("-o,--output", command->out, "write the scene to this file, and its shape files beside it")
      ->required();
  app->add_option("--drop", options.drop,
                  "leave these kinds out instead of refusing them; the first lines of the scene list what is left out")
      ->delimiter(',')
      ->check(CLI::IsMember(scene_import::droppable_kinds()));
  app->add_option("--proxy", options.proxy,
                  "proxy: the name of a moving body of the model, or the radius of a sphere [m];\n"
                  "default: a sphere of 0.01 m above the model");
  app->add_option("--proxy-position", command->proxy_position, "position X Y Z of the sphere of --proxy [m]")
      ->expected(3)
      ->delimiter(',');
  app->add_option("--device", options.device, "simulated device of the scene")
      ->check(CLI::IsMember({"virtuose6d", "desk3d"}))
      ->capture_default_str();
  app->add_option(
         "--pieces", options.pieces.most,
         "largest number of convex pieces into which a concave mesh that moves is divided; 1: its hull;\n"
         "default: 64 for glTF, OBJ and STL, or 128 with --deviation; for MJCF and URDF the hull, as in MuJoCo")
      ->check(in_range(1u, kMaxParts));
  app->add_option(
         "--deviation", command->deviation_mm,
         "largest distance between the pieces and the mesh [mm]; pieces that exceed it are refused. With neither\n"
         "--pieces nor --deviation: 1 mm or 1/100 of the mesh's size is aimed at, and what is reached is reported")
      ->check(in_range(0.001, 1000.0))
      ->capture_default_str();
  app->add_option("--unit", options.shapes.unit_m, "length of one unit of a glTF, OBJ or STL file [m]")
      ->check(in_range(1e-9, 1e3))
      ->capture_default_str();
  app->add_option("--density", options.shapes.density_kg_per_m3,
                  "density of bodies from glTF, OBJ and STL whose file gives none [kg/m3]")
      ->check(in_range(1e-3, 1e5))
      ->capture_default_str();
  app->add_flag("--fixed", options.shapes.fixed,
                "make bodies from glTF, OBJ and STL static, unless their file says otherwise");
  app->add_flag("--overwrite", command->overwrite, help::kOverwrite);
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, app, &exit_code] {
    command->options.needs_deviation = app->count("--deviation") > 0;
    exit_code = run_import(*command);
  });
  return app;
}

}  // namespace tactus::tools
