// Bullet, as its package is built: single precision, sequential impulses, one thread.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <btBulletDynamicsCommon.h>

#include "tools/experiment/engine.h"
#include "tools/experiment/scene_shapes.h"

namespace tactus::experiment {
namespace {

// Tuned: the margin in proportion to the cubes; the bounds of the walls, which never change, are not updated.
constexpr btScalar kTunedMargin_m = 1e-3f;

btVector3 as_bullet(const Vec3d& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}
btQuaternion as_bullet(const Quatd& q) {
  return {static_cast<btScalar>(q.x), static_cast<btScalar>(q.y), static_cast<btScalar>(q.z),
          static_cast<btScalar>(q.w)};
}
Vec3d from_bullet(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}
Posed from_bullet(const btTransform& t) {
  const btQuaternion q = t.getRotation();
  return {from_bullet(t.getOrigin()), normalized(Quatd{static_cast<double>(q.w()), static_cast<double>(q.x()),
                                                       static_cast<double>(q.y()), static_cast<double>(q.z())})};
}

class BulletEngine final : public Engine {
 public:
  BulletEngine(const BoxScene& scene, const EngineOptions& options)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broad_phase_, &solver_, &configuration_),
        step_s_(static_cast<btScalar>(scene.step_s)),
        stirrer_(scene.stirrer),
        gravity_m_per_s2_(scene.gravity_m_per_s2),
        turning_(scene.turning),
        tuned_(options.tuned),
        has_hulls_(!scene.hulls.empty()),
        cubes_(scene.cubes.size()) {
    world_.setGravity(as_bullet(scene.gravity_at(0)));
    if (tuned_) world_.setForceUpdateAllAabbs(false);
    if (options.iterations > 0) world_.getSolverInfo().m_numIterations = static_cast<int>(options.iterations);
    const auto friction = static_cast<btScalar>(scene.friction);
    for (const Cube& cube : scene.cubes) {
      add(shape_in_bullet(scene, cube), cube.mass_kg, as_bullet(inertia_of(scene, cube)), friction,
          btTransform(as_bullet(cube.rotation), as_bullet(cube.position)))
          ->setActivationState(DISABLE_DEACTIVATION);
    }
    for (const Wall& wall : scene.walls)
      add(box_in_bullet(wall.half_extents_m), 0, {0, 0, 0}, friction,
          btTransform(as_bullet(wall.rotation), as_bullet(wall.position)));
    if (scene.terrain) add_terrain(*scene.terrain, friction);
    for (std::uint32_t i = 0; i < rods_of(scene); ++i) {
      btRigidBody& rod = *add(box_in_bullet(stirrer_->half_extents_m), 0, {0, 0, 0}, friction, rod_at(i, 0));
      rod.setCollisionFlags(rod.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      rod.setActivationState(DISABLE_DEACTIVATION);
      rods_.push_back(&rod);
    }
  }

  ~BulletEngine() override {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  BulletEngine(const BulletEngine&) = delete;
  BulletEngine& operator=(const BulletEngine&) = delete;

  void step() override {
    if (turning_) world_.setGravity(as_bullet(gravity_m_per_s2_ * turning_->direction(time_s_)));
    time_s_ += static_cast<double>(step_s_);
    // Bullet computes a kinematic body's velocity from its previous and its next pose.
    for (std::size_t i = 0; i < rods_.size(); ++i) rods_[i]->getMotionState()->setWorldTransform(rod_at(i, time_s_));
    world_.stepSimulation(step_s_, 0);
  }

  Measurement measure() override {
    Measurement m;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
      double deepest = -1;
      for (int p = 0; p < manifold.getNumContacts(); ++p)
        deepest = std::max(deepest, -static_cast<double>(manifold.getContactPoint(p).getDistance()));
      m.contacts += manifold.getNumContacts();
      m.touching_pairs += deepest >= 0 ? 1 : 0;
    }
    m.residual_speed_m_per_s = residual_speed(cubes());
    return m;
  }

  std::vector<CubeState> cubes() const override {
    std::vector<CubeState> states;
    states.reserve(cubes_);
    for (std::size_t i = 0; i < cubes_; ++i) {
      const Posed pose = from_bullet(bodies_[i]->getWorldTransform());
      states.push_back({.position = pose.position,
                        .velocity = from_bullet(bodies_[i]->getLinearVelocity()),
                        .rotation = pose.rotation});
    }
    return states;
  }

  std::vector<Posed> rods() const override {
    std::vector<Posed> poses;
    for (const btRigidBody* rod : rods_) poses.push_back(from_bullet(rod->getWorldTransform()));
    return poses;
  }

  std::string settings() const override {
    return fmt::format(
        "{:.2f}, single precision, {} iterations{}", static_cast<double>(BT_BULLET_VERSION) / 100,
        world_.getSolverInfo().m_numIterations,
        tuned_ ? fmt::format(", margin {:g} mm, fixed bounds not refreshed", 1e3 * static_cast<double>(kTunedMargin_m))
        : has_hulls_ ? fmt::format(", margin of hulls {:g} mm", 1e3 * static_cast<double>(kTunedMargin_m))
                     : ", defaults");
  }

 private:
  btTransform rod_at(std::size_t rod, double time_s) const {
    return btTransform(btQuaternion::getIdentity(), as_bullet(stirrer_->pose_at(rod, time_s).position));
  }

  std::unique_ptr<btConvexShape> box_in_bullet(const Vec3d& half_extents_m) const {
    auto box = std::make_unique<btBoxShape>(as_bullet(half_extents_m));
    if (tuned_) box->setMargin(kTunedMargin_m);
    return box;
  }

  std::unique_ptr<btConvexShape> shape_in_bullet(const BoxScene& scene, const Cube& body) const {
    const physics::Shape shape = shape_of(scene, body);
    const auto radius = static_cast<btScalar>(shape.radius);
    if (shape.kind == physics::ShapeKind::kSphere) return std::make_unique<btSphereShape>(radius);
    if (shape.kind == physics::ShapeKind::kCapsule)
      return std::make_unique<btCapsuleShapeZ>(radius, static_cast<btScalar>(2 * shape.half_length));
    if (shape.kind != physics::ShapeKind::kHull) return box_in_bullet(shape.half_extents);
    auto hull = std::make_unique<btConvexHullShape>();
    const physics::Hull& source = scene.hulls[shape.index];
    for (std::uint32_t i = 0; i < source.topology.vertices; ++i) hull->addPoint(as_bullet(source.vertex(i)), false);
    hull->recalcLocalAabb();
    hull->setMargin(kTunedMargin_m);  // a margin is added to a hull: the default of 40 mm is as thick as the body
    return hull;
  }

  // With Bullet's data on inner edges: without them boxes catch on the seams.
  void add_terrain(const sim::BuiltMesh& terrain, btScalar friction) {
    const physics::Mesh& mesh = terrain.mesh;
    for (const auto& triangle : mesh.triangles)
      triangles_.addTriangle(as_bullet(mesh.place(triangle, 0)), as_bullet(mesh.place(triangle, 1)),
                             as_bullet(mesh.place(triangle, 2)));
    auto shape = std::make_unique<btBvhTriangleMeshShape>(&triangles_, true);
    if (tuned_) shape->setMargin(kTunedMargin_m);
    btGenerateInternalEdgeInfo(shape.get(), &edges_);
    btRigidBody* ground =
        add(std::move(shape), 0, {0, 0, 0}, friction,
            btTransform(as_bullet(terrain.given_from_body.rotation), as_bullet(terrain.given_from_body.position)));
    ground->setCollisionFlags(ground->getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper* a, int part_a, int index_a,
                               const btCollisionObjectWrapper* b, int part_b, int index_b) {
      const bool first = a->getCollisionShape()->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE;
      if (first)
        btAdjustInternalEdgeContacts(point, a, b, part_a, index_a);
      else
        btAdjustInternalEdgeContacts(point, b, a, part_b, index_b);
      return false;
    };
  }

  btRigidBody* add(std::unique_ptr<btCollisionShape> shape, double mass_kg, const btVector3& inertia, btScalar friction,
                   const btTransform& at) {
    motions_.push_back(std::make_unique<btDefaultMotionState>(at));
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass_kg), motions_.back().get(), shape.get(),
                                                  inertia);
    // Bullet multiplies the two coefficients; set so that the pair has the same coefficient as in the other engines.
    info.m_friction = std::sqrt(friction);
    info.m_restitution = 0;
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(bodies_.back().get());
    return bodies_.back().get();
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broad_phase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  btTriangleMesh triangles_;
  btTriangleInfoMap edges_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btDefaultMotionState>> motions_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  btScalar step_s_;
  std::optional<Stirrer> stirrer_;
  double gravity_m_per_s2_;
  std::optional<TurningGravity> turning_;
  bool tuned_, has_hulls_;
  std::size_t cubes_;
  std::vector<btRigidBody*> rods_;
  double time_s_{0};
};

}  // namespace

std::unique_ptr<Engine> make_bullet(const BoxScene& scene, const EngineOptions& options) {
  return std::make_unique<BulletEngine>(scene, options);
}

}  // namespace tactus::experiment
