#include "sim/geometry/shape_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <unordered_set>

#include "sim/geometry/shape_words.h"

namespace tactus::sim {
namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;  // bytes

// Collects positions without duplicates: triangles repeat their corners.
class Places {
 public:
  void add(const Vec3d& place) {
    if (seen_.insert(place).second) list_.push_back(place);
  }
  std::vector<Vec3d> take() { return std::move(list_); }

 private:
  struct Hash {
    std::size_t operator()(const Vec3d& v) const noexcept {
      std::uint64_t hash = 0;
      for (int i = 0; i < 3; ++i) hash = (hash ^ std::bit_cast<std::uint64_t>(v[i] + 0.0)) * 0x9e3779b97f4a7c15ull;
      return static_cast<std::size_t>(hash ^ (hash >> 29));
    }
  };
  std::unordered_set<Vec3d, Hash> seen_;
  std::vector<Vec3d> list_;
};

Result<std::vector<Vec3d>> not_empty(std::vector<Vec3d> places, std::string_view name, const char* accepted) {
  if (places.empty()) return Status::error(fmt::format("{}: holds no corners; accepted: {}", name, accepted));
  return places;
}

Result<std::vector<Vec3d>> parse_text_stl(std::string_view text, std::string_view name) {
  Words words(text);
  std::vector<Vec3d> corners;
  words.skip_line();  // "solid" and its name
  while (true) {
    const std::string_view word = words.next(false);
    if (word.empty()) break;
    if (word == "solid") words.skip_line();
    if (word != "vertex") continue;
    Vec3d place;
    if (const std::string wrong = read_place(words, place); !wrong.empty())
      return Status::error(fmt::format("{}:{}: {}; accepted: vertex x y z", name, words.line(), wrong));
    corners.push_back(place);
  }
  return not_empty(std::move(corners), name, "facets with lines \"vertex x y z\"");
}

Result<std::vector<Vec3d>> parse_binary_stl(std::string_view bytes, std::string_view name) {
  static_assert(std::endian::native == std::endian::little);
  std::vector<Vec3d> corners;
  const std::size_t triangles = (bytes.size() - kStlHeader) / kStlTriangle;
  for (std::size_t t = 0; t < triangles; ++t) {
    float numbers[12];  // the normal (not used) and three corners
    std::memcpy(numbers, bytes.data() + kStlHeader + t * kStlTriangle, sizeof numbers);
    for (int corner = 1; corner < 4; ++corner) {
      const float* p = numbers + 3 * corner;
      const Vec3d place{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
      if (!is_finite(place))
        return Status::error(
            fmt::format("{}: triangle {} has a corner that is not finite; accepted: finite numbers", name, t + 1));
      corners.push_back(place);
    }
  }
  return not_empty(std::move(corners), name, "one triangle or more");
}

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace

Result<std::vector<Vec3d>> parse_obj(std::string_view text, std::string_view name) {
  Words words(text);
  Places places;
  while (true) {
    const std::string_view word = words.next(false);
    if (word.empty()) break;
    if (word == "v") {
      Vec3d place;
      if (const std::string wrong = read_place(words, place); !wrong.empty())
        return Status::error(fmt::format("{}:{}: {}; accepted: v x y z", name, words.line(), wrong));
      places.add(place);
    }
    words.skip_line();
  }
  return not_empty(places.take(), name, "lines \"v x y z\"");
}

// Some programs start binary files with "solid" too, so the size is checked first.
Result<std::vector<Vec3d>> parse_stl_corners(std::string_view bytes, std::string_view name) {
  if (bytes.size() >= kStlHeader) {
    std::uint32_t triangles = 0;
    std::memcpy(&triangles, bytes.data() + kStlHeader - 4, sizeof triangles);
    if (bytes.size() == kStlHeader + std::size_t{triangles} * kStlTriangle) return parse_binary_stl(bytes, name);
    if (bytes.substr(0, 5) != "solid")
      return Status::error(
          fmt::format("{}: {} bytes, but its header announces {} triangles, {} bytes; accepted: a whole STL file", name,
                      bytes.size(), triangles, kStlHeader + std::size_t{triangles} * kStlTriangle));
  }
  if (bytes.substr(0, 5) == "solid") return parse_text_stl(bytes, name);
  return Status::error(fmt::format("{}: is no STL file; accepted: STL, text or binary", name));
}

Result<std::vector<Vec3d>> parse_stl(std::string_view bytes, std::string_view name) {
  auto corners = parse_stl_corners(bytes, name);
  if (!corners.ok()) return corners;
  Places places;
  for (const Vec3d& corner : corners.value()) places.add(corner);
  return places.take();
}

Result<ShapeFile> open_shape_file(const std::filesystem::path& path) {
  const std::string name = path.string(), ending = lower(path.extension().string());
  if (ending != ".obj" && ending != ".stl")
    return Status::error(fmt::format("{}: is of an unknown kind; accepted: a name that ends in .obj or .stl", name));
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return Status::error(fmt::format("{}: there is no such file; accepted: a path from the scene file's folder", name));
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kMaxShapeFileBytes)
    return Status::error(fmt::format("{}: is too large; accepted: at most {} bytes", name, kMaxShapeFileBytes));
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    return Status::error(fmt::format("{}: cannot be read; accepted: a file that you may read", name));
  return ShapeFile{name, std::move(bytes), ending == ".obj"};
}

Result<std::vector<Vec3d>> read_shape_file(const std::filesystem::path& path) {
  const auto file = open_shape_file(path);
  if (!file.ok()) return file.status();
  const auto& [name, bytes, is_obj] = file.value();
  return is_obj ? parse_obj(bytes, name) : parse_stl(bytes, name);
}

}  // namespace tactus::sim
