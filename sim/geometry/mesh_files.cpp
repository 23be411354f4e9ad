#include "sim/geometry/mesh_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "sim/geometry/shape_files.h"
#include "sim/geometry/shape_words.h"

namespace tactus::sim {
namespace {

Status too_many(std::string_view name, std::size_t line, const char* what, std::size_t limit) {
  const std::string place = line == 0 ? "" : fmt::format(":{}", line);
  return Status::error(fmt::format("{}{}: more than {} {}; accepted: at most {}", name, place, limit, what, limit));
}

// Parses "7", "7/1/2" or "-1": the first number, from 1 or from the end. False if it is none of the corners so far.
bool parse_corner(std::string_view word, std::size_t corners, std::uint32_t& index) {
  word = word.substr(0, word.find('/'));
  long long number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc{} || end != word.data() + word.size() || word.empty()) return false;
  const auto count = static_cast<long long>(corners);
  if (number < 0) number += count + 1;
  if (number < 1 || number > count) return false;
  index = static_cast<std::uint32_t>(number - 1);
  return true;
}

// Reads a face as a fan of triangles. Returns an error's text, or empty.
std::string read_face(Words& words, TriangleSoup& soup) {
  std::uint32_t corner[3] = {0, 0, 0};
  unsigned count = 0;
  for (std::string_view word = words.next(true); !word.empty(); word = words.next(true), ++count) {
    std::uint32_t index = 0;
    if (!parse_corner(word, soup.corners.size(), index))
      return fmt::format("{} is none of the {} corners before it", shown(word), soup.corners.size());
    if (count > 2) corner[1] = corner[2];
    corner[std::min(count, 2u)] = index;
    if (count < 2) continue;
    soup.triangles.push_back({corner[0], corner[1], corner[2]});
    if (soup.triangles.size() > kMaxMeshTriangles) return {};
  }
  return count < 3 ? fmt::format("a face with {} corners", count) : std::string();
}

}  // namespace

Result<TriangleSoup> parse_obj_triangles(std::string_view text, std::string_view name) {
  Words words(text);
  TriangleSoup soup;
  while (true) {
    const std::string_view word = words.next(false);
    if (word.empty()) break;
    if (word == "v") {
      Vec3d place;
      if (const std::string wrong = read_place(words, place); !wrong.empty())
        return Status::error(fmt::format("{}:{}: {}; accepted: v x y z", name, words.line(), wrong));
      soup.corners.push_back(place);
      if (soup.corners.size() > kMaxMeshCorners) return too_many(name, words.line(), "corners", kMaxMeshCorners);
    } else if (word == "f") {
      const std::size_t line = words.line();
      if (const std::string wrong = read_face(words, soup); !wrong.empty())
        return Status::error(fmt::format("{}:{}: {}; accepted: f a b c, numbers of corners", name, line, wrong));
      if (soup.triangles.size() > kMaxMeshTriangles) return too_many(name, line, "triangles", kMaxMeshTriangles);
    }
    words.skip_line();
  }
  if (soup.triangles.empty())
    return Status::error(fmt::format("{}: holds no triangles; accepted: lines \"f a b c\"", name));
  return soup;
}

Result<TriangleSoup> parse_stl_triangles(std::string_view bytes, std::string_view name) {
  auto corners = parse_stl_corners(bytes, name);
  if (!corners.ok()) return corners.status();
  TriangleSoup soup;
  soup.corners = std::move(corners).value();
  const std::size_t count = soup.corners.size();
  if (count % 3 != 0)
    return Status::error(
        fmt::format("{}: {} corners make no whole triangles; accepted: three corners each", name, count));
  if (count / 3 > kMaxMeshTriangles) return too_many(name, 0, "triangles", kMaxMeshTriangles);
  for (std::uint32_t i = 0; i < count; i += 3) soup.triangles.push_back({i, i + 1, i + 2});
  return soup;
}

Result<TriangleSoup> read_triangle_file(const std::filesystem::path& path) {
  const auto file = open_shape_file(path);
  if (!file.ok()) return file.status();
  const auto& [name, bytes, is_obj] = file.value();
  return is_obj ? parse_obj_triangles(bytes, name) : parse_stl_triangles(bytes, name);
}

}  // namespace tactus::sim
