// ODE, as its package is built: double precision, the quick step (projected Gauss-Seidel), one thread.
#include <fmt/format.h>
#include <ode/ode.h>

#include <algorithm>
#include <array>

#include "tools/experiment/engine.h"
#include "tools/experiment/scene_shapes.h"

namespace tactus::experiment {
namespace {

constexpr int kPointsPerPair = 4;
// Tuned: half the sweeps of the default, and a broad phase by sorting, which keeps its memory.
constexpr int kTunedIterations = 10;

struct OdeLibrary {  // ODE does not count its initialisations, so once per process
  OdeLibrary() { dInitODE2(0); }
  ~OdeLibrary() { dCloseODE(); }
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;
};

Vec3d from_ode(const dReal* v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}
Quatd rotation_of(const dReal* q) {
  return {static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2]), static_cast<double>(q[3])};
}

// Data of a convex geometry, which ODE does not copy.
class OdeHull {
 public:
  explicit OdeHull(const physics::Hull& hull) {
    const physics::HullTopology& topology = hull.topology;
    for (std::uint32_t i = 0; i < topology.vertices; ++i) put(points_, hull.vertex(i));
    for (std::uint32_t f = 0; f < topology.faces; ++f) {
      put(planes_, hull.normal(f));
      planes_.push_back(hull.offsets[f]);
      const auto loop = topology.loop(f);
      polygons_.push_back(static_cast<unsigned>(loop.size()));
      polygons_.insert(polygons_.end(), loop.begin(), loop.end());
    }
  }
  dGeomID make(dSpaceID space) const {
    return dCreateConvex(space, planes_.data(), static_cast<unsigned>(planes_.size() / 4), points_.data(),
                         static_cast<unsigned>(points_.size() / 3), polygons_.data());
  }

 private:
  static void put(std::vector<dReal>& to, const Vec3d& v) { to.insert(to.end(), {v.x, v.y, v.z}); }

  std::vector<dReal> planes_, points_;
  std::vector<unsigned> polygons_;
};

class OdeEngine final : public Engine {
 public:
  OdeEngine(const BoxScene& scene, const EngineOptions& options)
      : step_s_(scene.step_s),
        friction_(scene.friction),
        stirrer_(scene.stirrer),
        gravity_m_per_s2_(scene.gravity_m_per_s2),
        turning_(scene.turning),
        tuned_(options.tuned) {
    static const OdeLibrary library;
    world_ = dWorldCreate();
    space_ = tuned_ ? dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ) : dHashSpaceCreate(nullptr);
    joints_ = dJointGroupCreate(0);
    set_gravity(scene.gravity_at(0));
    dWorldSetAutoDisableFlag(world_, 0);
    if (tuned_) dWorldSetQuickStepNumIterations(world_, kTunedIterations);
    if (options.iterations > 0) dWorldSetQuickStepNumIterations(world_, static_cast<int>(options.iterations));
    for (const auto& hull : scene.hulls) hulls_.emplace_back(hull);
    for (const Cube& cube : scene.cubes) cubes_.push_back(add_body(scene, cube));
    for (const Wall& wall : scene.walls) {
      const Vec3d size = 2.0 * wall.half_extents_m;
      const dGeomID box = dCreateBox(space_, size.x, size.y, size.z);
      dGeomSetPosition(box, wall.position.x, wall.position.y, wall.position.z);
      const dQuaternion q{wall.rotation.w, wall.rotation.x, wall.rotation.y, wall.rotation.z};
      dGeomSetQuaternion(box, q);
    }
    if (scene.terrain) add_terrain(*scene.terrain);
    if (stirrer_) add_rods();
  }

  ~OdeEngine() override {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    if (terrain_ != nullptr) dGeomTriMeshDataDestroy(terrain_);
    dWorldDestroy(world_);
  }
  OdeEngine(const OdeEngine&) = delete;
  OdeEngine& operator=(const OdeEngine&) = delete;

  void step() override {
    if (turning_) set_gravity(gravity_m_per_s2_ * turning_->direction(time_s_));
    // ODE moves a kinematic body by its velocity.
    for (std::size_t i = 0; i < rods_.size(); ++i) {
      const Vec3d v = stirrer_->velocity_over(i, from_ode(dBodyGetPosition(rods_[i])), time_s_, step_s_).linear;
      dBodySetLinearVel(rods_[i], v.x, v.y, v.z);
    }
    facts_ = {};
    dSpaceCollide(space_, this, [](void* self, dGeomID a, dGeomID b) { static_cast<OdeEngine*>(self)->collide(a, b); });
    dWorldQuickStep(world_, step_s_);
    dJointGroupEmpty(joints_);
    time_s_ += step_s_;
  }

  Measurement measure() override {
    Measurement m = facts_;
    m.residual_speed_m_per_s = residual_speed(cubes());
    return m;
  }

  std::vector<CubeState> cubes() const override {
    std::vector<CubeState> states;
    states.reserve(cubes_.size());
    for (const dBodyID body : cubes_)
      states.push_back(
          {from_ode(dBodyGetPosition(body)), from_ode(dBodyGetLinearVel(body)), rotation_of(dBodyGetQuaternion(body))});
    return states;
  }

  std::vector<Posed> rods() const override {
    std::vector<Posed> poses;
    for (const dBodyID rod : rods_)
      poses.push_back({from_ode(dBodyGetPosition(rod)), rotation_of(dBodyGetQuaternion(rod))});
    return poses;
  }

  std::string settings() const override {
    return fmt::format("{} precision, quick step, {} iterations, {} points a pair{}, {}",
                       sizeof(dReal) == sizeof(double) ? "double" : "single", dWorldGetQuickStepNumIterations(world_),
                       kPointsPerPair, hulls_.empty() ? "" : " (hulls one)",
                       tuned_ ? "sweep-and-prune space" : "hash space, defaults");
  }

 private:
  dBodyID add_body(const BoxScene& scene, const Cube& cube) {
    const dBodyID body = dBodyCreate(world_);
    dMass mass;
    const Vec3d inertia = inertia_of(scene, cube);
    dMassSetParameters(&mass, cube.mass_kg, 0, 0, 0, inertia.x, inertia.y, inertia.z, 0, 0, 0);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, cube.position.x, cube.position.y, cube.position.z);
    const dQuaternion q{cube.rotation.w, cube.rotation.x, cube.rotation.y, cube.rotation.z};
    dBodySetQuaternion(body, q);
    dGeomSetBody(geometry_of(shape_of(scene, cube)), body);
    return body;
  }

  dGeomID geometry_of(const physics::Shape& shape) {
    const Vec3d size = 2.0 * shape.half_extents;
    switch (shape.kind) {
      case physics::ShapeKind::kSphere:
        return dCreateSphere(space_, shape.radius);
      case physics::ShapeKind::kCapsule:
        return dCreateCapsule(space_, shape.radius, 2 * shape.half_length);
      case physics::ShapeKind::kHull:
        return hulls_[shape.index].make(space_);
      default:
        return dCreateBox(space_, size.x, size.y, size.z);
    }
  }

  void set_gravity(const Vec3d& g) { dWorldSetGravity(world_, g.x, g.y, g.z); }

  void add_terrain(const sim::BuiltMesh& terrain) {
    for (const Vec3d& corner : terrain.mesh.corners) corners_.insert(corners_.end(), {corner.x, corner.y, corner.z});
    for (const auto& triangle : terrain.mesh.triangles)
      indices_.insert(indices_.end(), triangle.corner.begin(), triangle.corner.end());
    terrain_ = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(terrain_, corners_.data(), 3 * sizeof(double), static_cast<int>(corners_.size() / 3),
                                indices_.data(), static_cast<int>(indices_.size()), 3 * sizeof(dTriIndex));
    const dGeomID mesh = dCreateTriMesh(space_, terrain_, nullptr, nullptr, nullptr);
    const Posed& at = terrain.given_from_body;
    dGeomSetPosition(mesh, at.position.x, at.position.y, at.position.z);
    const dQuaternion q{at.rotation.w, at.rotation.x, at.rotation.y, at.rotation.z};
    dGeomSetQuaternion(mesh, q);
  }

  void add_rods() {
    const Vec3d size = 2.0 * stirrer_->half_extents_m;
    for (std::size_t i = 0; i < stirrer_->centres_m.size(); ++i) {
      const dBodyID rod = dBodyCreate(world_);
      const Vec3d at = stirrer_->pose_at(i, 0).position;
      dBodySetPosition(rod, at.x, at.y, at.z);
      dBodySetKinematic(rod);
      dGeomSetBody(dCreateBox(space_, size.x, size.y, size.z), rod);
      rods_.push_back(rod);
    }
  }

  static bool is_moved_by_forces(dBodyID body) { return body != nullptr && dBodyIsKinematic(body) == 0; }

  void collide(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (!is_moved_by_forces(body_a) && !is_moved_by_forces(body_b)) return;
    std::array<dContact, kPointsPerPair> contacts;
    const int count = dCollide(a, b, kPointsPerPair, &contacts[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      dContact& contact = contacts[static_cast<std::size_t>(i)];
      contact.surface = {};
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = friction_;
      dJointAttach(dJointCreateContact(world_, joints_, &contact), body_a, body_b);
    }
    facts_.contacts += count;
    facts_.touching_pairs += count > 0 ? 1 : 0;  // ODE reports no contact before bodies overlap
  }

  dWorldID world_{};
  dSpaceID space_{};
  dJointGroupID joints_{};
  double step_s_, friction_;
  std::optional<Stirrer> stirrer_;
  double gravity_m_per_s2_;
  std::optional<TurningGravity> turning_;
  dTriMeshDataID terrain_{nullptr};  // refers to the two lists
  std::vector<double> corners_;
  std::vector<dTriIndex> indices_;
  bool tuned_;
  std::vector<OdeHull> hulls_;
  std::vector<dBodyID> cubes_, rods_;
  Measurement facts_;  // of the last step, except the speed
  double time_s_{0};
};

}  // namespace

std::unique_ptr<Engine> make_ode(const BoxScene& scene, const EngineOptions& options) {
  return std::make_unique<OdeEngine>(scene, options);
}

}  // namespace tactus::experiment
