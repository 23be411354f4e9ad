// Reads the [hand] of a scene, or each of its [[hand]]: way points in the text, or a recorded motion in a file beside
// it.
//
// A file's rows are stored at the end of the scene's source as a [[motion_file]] table, as hulls and meshes are, so
// that a tape replays without the file.
// Thread: [setup]. Mistakes go to the reader's diagnostics.
#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include "rt/text/table_reader.h"
#include "sim/loader/motion_file.h"
#include "sim/loader/scene_load.h"
#include "sim/model/scene.h"

namespace tactus::sim {

class HandReader {
 public:
  // `folder`: file names are relative to it; none: no file is opened.
  HandReader(Scene& scene, text::Diagnostics& diagnostics, std::optional<std::filesystem::path> folder)
      : scene_(scene), diagnostics_(diagnostics), folder_(std::move(folder)) {}

  // The [[motion_file]] tables of the text.
  void read_kept(std::span<const text::TomlNode> tables);
  // Call after the proxy that the hand holds has been read.
  void read(text::TableReader hand, HandScript& script, BodyId proxy);

  // Text to append to the source, so that it needs no file.
  const std::string& kept() const { return kept_; }

 private:
  void read_waypoint(const text::TomlNode& node, unsigned number);
  void read_file(text::TableReader& hand);
  bool open_file(text::TableReader& hand, const std::string& name, std::vector<MotionRow>& rows);
  void add_rows(const std::vector<MotionRow>& rows);
  void check_path(text::TableReader& hand, const char* key, BodyId proxy);

  Scene& scene_;
  HandScript* script_{nullptr};  // that is being read
  text::Diagnostics& diagnostics_;
  std::optional<std::filesystem::path> folder_;
  std::map<std::string, std::vector<MotionRow>> given_;  // from the text
  std::string kept_;
};

}  // namespace tactus::sim
