#include "sim/geometry/hull_gap.h"

#include <algorithm>
#include <limits>
#include <queue>

namespace tactus::sim {
namespace {

using physics::Hull;
using physics::Mesh;

struct Piece {
  Vec3d corner[3];
  double most_m{0};  // upper bound on the distance of its points
};

double distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double square = dot(ab, ab);
  const double share = square > 0 ? std::clamp(dot(p - a, ab) / square, 0.0, 1.0) : 0.0;
  return norm(p - (a + ab * share));
}

double distance_to_triangle(const Vec3d& p, const Vec3d (&t)[3]) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  bool over = dot(normal, normal) > 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec3d& a = t[k];
    const Vec3d& b = t[(k + 1) % 3];
    over = over && dot(cross(b - a, p - a), normal) >= 0;
    nearest = std::min(nearest, distance_to_segment(p, a, b));
  }
  return over ? std::min(nearest, std::abs(dot(p - t[0], normal)) / norm(normal)) : nearest;
}

double distance_to_box(const Vec3d& p, const physics::Aabb& box) {
  Vec3d d;
  for (int i = 0; i < 3; ++i) d[i] = std::max({box.lower[i] - p[i], 0.0, p[i] - box.upper[i]});
  return norm(d);
}

// Distance to the surface of the mesh.
class MeshSurface {
 public:
  explicit MeshSurface(const Mesh& mesh) : mesh_(mesh) {}

  double distance(const Vec3d& p) const { return find(p).distance_m; }

  // Upper bound for a piece. The distance to one triangle is convex, so it is largest at a corner of the piece.
  double most(const Piece& piece, const Vec3d& middle) const {
    Vec3d nearest[3];
    corners_of(find(middle).triangle, nearest);
    double most_m = 0;
    for (const Vec3d& corner : piece.corner) most_m = std::max(most_m, distance_to_triangle(corner, nearest));
    return most_m;
  }

 private:
  struct Nearest {
    double distance_m{std::numeric_limits<double>::infinity()};
    std::uint32_t triangle{0};
  };

  void corners_of(std::uint32_t triangle, Vec3d (&corner)[3]) const {
    for (int k = 0; k < 3; ++k) corner[k] = mesh_.place(mesh_.triangles[triangle], k);
  }

  Nearest find(const Vec3d& p) const {
    Nearest best;
    look(p, 0, best);
    return best;
  }

  void look(const Vec3d& p, std::uint32_t at, Nearest& best) const {
    const auto& node = mesh_.nodes[at];
    if (distance_to_box(p, node.box) >= best.distance_m) return;
    if (node.second == 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        Vec3d corner[3];
        corners_of(mesh_.order[i], corner);
        if (const double d = distance_to_triangle(p, corner); d < best.distance_m) best = {d, mesh_.order[i]};
      }
      return;
    }
    const std::uint32_t first = at + 1, second = node.second;
    const bool swap = distance_to_box(p, mesh_.nodes[second].box) < distance_to_box(p, mesh_.nodes[first].box);
    look(p, swap ? second : first, best);
    look(p, swap ? first : second, best);
  }

  Mesh mesh_;
};

// Distance to the surface of the hull, from inside: the depth of a point.
class HullSurface {
 public:
  HullSurface(const Hull& hull, const Posed& mesh_from_hull) {
    for (std::uint32_t f = 0; f < hull.topology.faces; ++f) {
      const Vec3d normal = rotate(mesh_from_hull.rotation, hull.normal(f));
      planes_.push_back({normal, hull.offsets[f] + dot(normal, mesh_from_hull.position)});
    }
  }

  double distance(const Vec3d& p) const {
    double depth_m = std::numeric_limits<double>::infinity();
    for (const auto& plane : planes_) depth_m = std::min(depth_m, plane.offset - dot(plane.normal, p));
    return std::max(depth_m, 0.0);
  }

  // Upper bound for a piece. The depth below one plane is linear, so it is largest at a corner of the piece.
  double most(const Piece& piece, const Vec3d&) const {
    double most_m = std::numeric_limits<double>::infinity();
    for (const auto& plane : planes_) {
      double deepest = 0;
      for (const Vec3d& corner : piece.corner) deepest = std::max(deepest, plane.offset - dot(plane.normal, corner));
      most_m = std::min(most_m, deepest);
    }
    return most_m;
  }

 private:
  struct Plane {
    Vec3d normal;
    double offset;
  };
  std::vector<Plane> planes_;
};

// Finds the largest distance of a point on the pieces to the surface; updates `gap` if it is larger.
template <class Surface>
void search(const std::vector<Piece>& pieces, const Surface& surface, double tolerance_m, HullGap& gap) {
  const auto less = [](const Piece& a, const Piece& b) { return a.most_m < b.most_m; };
  std::priority_queue<Piece, std::vector<Piece>, decltype(less)> open(less);
  const auto take = [&](Piece piece) {
    const Vec3d middle = (piece.corner[0] + piece.corner[1] + piece.corner[2]) * (1.0 / 3);
    const auto look = [&](const Vec3d& p) {
      if (const double d = surface.distance(p); d > gap.gap_m) {
        gap.gap_m = d;
        gap.at_m = p;
      }
    };
    double radius_m = 0;
    for (const Vec3d& corner : piece.corner) {
      look(corner);
      radius_m = std::max(radius_m, norm(corner - middle));
    }
    look(middle);
    piece.most_m = std::min(surface.distance(middle) + radius_m, surface.most(piece, middle));
    if (piece.most_m > gap.gap_m + tolerance_m) open.push(piece);
  };
  for (const Piece& piece : pieces) take(piece);
  for (unsigned i = 0; i < kMaxGapPieces && !open.empty(); ++i) {
    const Piece piece = open.top();
    open.pop();
    if (piece.most_m <= gap.gap_m + tolerance_m) return;  // the queue's largest bound
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (norm(piece.corner[(k + 1) % 3] - piece.corner[k]) >
          norm(piece.corner[(longest + 1) % 3] - piece.corner[longest]))
        longest = k;
    const Vec3d a = piece.corner[longest], b = piece.corner[(longest + 1) % 3], c = piece.corner[(longest + 2) % 3];
    const Vec3d between = 0.5 * (a + b);
    take({{a, between, c}});
    take({{between, b, c}});
  }
}

std::vector<Piece> pieces_of(const Mesh& mesh) {
  std::vector<Piece> pieces;
  for (const auto& t : mesh.triangles) pieces.push_back({{mesh.place(t, 0), mesh.place(t, 1), mesh.place(t, 2)}});
  return pieces;
}

std::vector<Piece> pieces_of(const Hull& hull, const Posed& mesh_from_hull) {
  std::vector<Piece> pieces;
  for (std::uint32_t f = 0; f < hull.topology.faces; ++f) {
    const auto loop = hull.topology.loop(f);
    for (std::size_t i = 2; i < loop.size(); ++i)
      pieces.push_back({{mesh_from_hull * hull.vertex(loop[0]), mesh_from_hull * hull.vertex(loop[i - 1]),
                         mesh_from_hull * hull.vertex(loop[i])}});
  }
  return pieces;
}

}  // namespace

Result<HullGap> find_hull_gap(const TriangleSoup& soup, const Hull& hull, const Posed& given_from_hull) {
  const auto built = build_mesh(soup, physics::kFirstPatchId);
  if (!built.ok()) return built.status();
  const Mesh& mesh = built.value().mesh;
  const Posed& given_from_mesh = built.value().given_from_body;
  const Posed mesh_from_hull = inverse(given_from_mesh) * given_from_hull;
  const double tolerance_m = std::max(norm(mesh.half_extents) / 100, 1e-6);
  HullGap gap;
  gap.open_edges = built.value().account.boundary_edges;
  search(pieces_of(mesh), HullSurface(hull, mesh_from_hull), tolerance_m, gap);
  search(pieces_of(hull, mesh_from_hull), MeshSurface(mesh), tolerance_m, gap);
  gap.at_m = given_from_mesh * gap.at_m;
  return gap;
}

}  // namespace tactus::sim
