#include "tools/import/gltf_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "rt/text/read_file.h"
#include "tools/import/shape_source.h"

namespace tactus::scene_import {
namespace {

using nlohmann::json;

// Header of a GLB: magic, version, length; then its first chunk: length, "JSON", text.
constexpr std::size_t kGlbText = 20;

std::string json_text_of(const std::filesystem::path& file) {
  const std::string bytes = text::read_file(file, kMaxFileBytes).value_or("");
  if (!bytes.starts_with("glTF") || bytes.size() < kGlbText) return bytes;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  return bytes.substr(kGlbText, length);
}

unsigned nesting_of(const std::string& text) {
  unsigned depth = 0, most = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '{' || c == '[') most = std::max(most, ++depth);
    if ((c == '}' || c == ']') && depth > 0) --depth;
  }
  return most;
}

// For each node its children that there are.
std::vector<std::vector<std::size_t>> children_of(const json& nodes) {
  std::vector<std::vector<std::size_t>> children(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].is_object()) continue;
    const auto list = nodes[i].find("children");
    if (list == nodes[i].end() || !list->is_array()) continue;
    for (const json& child : *list)
      if (child.is_number_unsigned() && child.get<std::uint64_t>() < nodes.size())
        children[i].push_back(child.get<std::size_t>());
  }
  return children;
}

bool nodes_are_deep(const json& nodes) {
  const auto children = children_of(nodes);
  std::vector<char> here(children.size(), 1);  // 1: the node has at least `depth` ancestors
  for (unsigned depth = 0; depth <= kMaxNodeDepth; ++depth) {
    std::vector<char> below(children.size(), 0);
    bool any = false;
    for (std::size_t i = 0; i < children.size(); ++i)
      for (const std::size_t child : children[i])
        if (here[i] != 0) {
          below[child] = 1;
          any = true;
        }
    if (!any) return false;
    here = std::move(below);
  }
  return true;
}

}  // namespace

std::string gltf_depth_problem(const std::filesystem::path& file) {
  const std::string text = json_text_of(file);
  if (nesting_of(text) > kMaxNodeDepth) return fmt::format("has JSON nested deeper than {}", kMaxNodeDepth);
  const json document = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!document.is_object() || !document.contains("nodes") || !document.at("nodes").is_array()) return {};
  return nodes_are_deep(document.at("nodes")) ? fmt::format("has nodes deeper than {}, or in a circle", kMaxNodeDepth)
                                              : std::string();
}

}  // namespace tactus::scene_import
