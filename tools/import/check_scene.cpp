#include "tools/import/check_scene.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <sstream>

#include "sim/loader/scene_load.h"
#include "tools/private_folder.h"

namespace tactus::scene_import {
namespace {

bool write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  return file.flush().good();
}

// An element of the model, as a comment behind the head of its table has it: 'geom "head", line 42'.
struct Element {
  std::string label;
  unsigned line{0};
};

Element element_of(const std::string& head) {
  const std::size_t comment = head.find("]  # ");
  if (comment == std::string::npos) return {};
  Element element{head.substr(comment + 5), 0};
  const std::size_t at = element.label.rfind(", line ");
  if (at == std::string::npos) return element;
  const char* const end = element.label.data() + element.label.size();
  const auto [read_to, error] = std::from_chars(element.label.data() + at + 7, end, element.line);
  if (error != std::errc() || read_to != end) return {element.label, 0};
  element.label.resize(at);
  return element;
}

// By line of the scene, from 1.
std::vector<Element> elements_of(const std::string& text) {
  std::vector<Element> elements(1);
  std::istringstream lines(text);
  Element here;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("[")) here = element_of(line);
    elements.push_back(here);
  }
  return elements;
}

// "mass_kg" of "[body.3] mass_kg".
std::string key_of(const std::string& where) {
  const std::size_t end = where.rfind("] ");
  return end == std::string::npos ? where : where.substr(end + 2);
}

}  // namespace

Status check_scene(const SceneFiles& files, const std::string& model, CheckScope scope, Account& account) {
  const auto made = PrivateFolder::make();
  if (!made.ok()) return made.status();
  const std::filesystem::path& folder = made.value()->path();
  bool written = write_file(folder / "scene.toml", files.text);
  for (const auto& [name, text] : files.shapes) written = written && write_file(folder / name, text);
  if (!written) return Status::error("temporary files cannot be written; accepted: TMPDIR on a disk with free space");
  text::Diagnostics found;
  if (sim::load_scene(folder / "scene.toml", &found).ok()) return Status::good();
  found.sort_by_place();
  const auto elements = elements_of(files.text);
  for (const text::Mistake& mistake : found.mistakes) {
    const Element element = mistake.line < elements.size() ? elements[mistake.line] : Element{};
    if (!element.label.empty())
      account.refuse({.kind = "",
                      .file = model,
                      .line = element.line,
                      .what = fmt::format("{}: {}: {}", element.label, key_of(mistake.where), mistake.what),
                      .accepted = mistake.accepted});
    else if (scope == CheckScope::kWhole)
      account.refuse({.kind = "",
                      .file = model,
                      .line = 0,
                      .what = fmt::format("its scene: {}: {}", mistake.where, mistake.what),
                      .accepted = mistake.accepted});
  }
  if (found.left_out > 0)
    account.refuse({.kind = "",
                    .file = model,
                    .line = 0,
                    .what = fmt::format("{} more values that a scene cannot have", found.left_out),
                    .accepted = "fewer"});
  return Status::good();
}

}  // namespace tactus::scene_import
