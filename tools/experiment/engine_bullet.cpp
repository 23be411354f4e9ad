// Bullet, as its package is built: single precision, sequential impulses, one thread.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <btBulletDynamicsCommon.h>

#include "tools/experiment/engine.h"

namespace tactus::experiment {
namespace {

// Tuned: the margin scaled to the cubes, and the walls' bounds, which never change, not refreshed.
constexpr btScalar kTunedMargin_m = 1e-3f;

btVector3 as_bullet(const Vec3d& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}
Vec3d from_bullet(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

class BulletEngine final : public Engine {
 public:
  BulletEngine(const BoxScene& scene, const EngineOptions& options)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broad_phase_, &solver_, &configuration_),
        step_s_(static_cast<btScalar>(scene.step_s)),
        paddle_(scene.paddle),
        tuned_(options.tuned),
        cubes_(scene.cubes.size()) {
    world_.setGravity({0, 0, static_cast<btScalar>(-scene.gravity_m_per_s2)});
    if (tuned_) world_.setForceUpdateAllAabbs(false);
    const auto friction = static_cast<btScalar>(scene.friction);
    for (const Cube& cube : scene.cubes) {
      const double half = 0.5 * cube.edge_m;
      const btTransform at({static_cast<btScalar>(cube.rotation.x), static_cast<btScalar>(cube.rotation.y),
                            static_cast<btScalar>(cube.rotation.z), static_cast<btScalar>(cube.rotation.w)},
                           as_bullet(cube.position));
      add({half, half, half}, cube.mass_kg, friction, at)->setActivationState(DISABLE_DEACTIVATION);
    }
    for (const Wall& wall : scene.walls)
      add(wall.half_extents_m, 0, friction, btTransform{btQuaternion::getIdentity(), as_bullet(wall.position)});
    if (!paddle_) return;
    rod_ = add(paddle_->half_extents_m, 0, friction,
               btTransform{btQuaternion::getIdentity(), as_bullet(paddle_->position_at(0))});
    rod_->setCollisionFlags(rod_->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    rod_->setActivationState(DISABLE_DEACTIVATION);
  }

  ~BulletEngine() override {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  BulletEngine(const BulletEngine&) = delete;
  BulletEngine& operator=(const BulletEngine&) = delete;

  void step() override {
    time_s_ += static_cast<double>(step_s_);
    if (rod_ != nullptr) {
      // Bullet takes a kinematic body's velocity from where it was and where it is to be.
      rod_->getMotionState()->setWorldTransform(
          btTransform{btQuaternion::getIdentity(), as_bullet(paddle_->position_at(time_s_))});
    }
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
      m.penetration_m = std::max(m.penetration_m, deepest);
    }
    m.residual_speed_m_per_s = residual_speed(cubes());
    return m;
  }

  std::vector<CubeState> cubes() const override {
    std::vector<CubeState> states;
    states.reserve(cubes_);
    for (std::size_t i = 0; i < cubes_; ++i)
      states.push_back(
          {from_bullet(bodies_[i]->getWorldTransform().getOrigin()), from_bullet(bodies_[i]->getLinearVelocity())});
    return states;
  }

  std::string settings() const override {
    return fmt::format(
        "{:.2f}, single precision, {} iterations{}", static_cast<double>(BT_BULLET_VERSION) / 100, 10,
        tuned_ ? fmt::format(", margin {:g} mm, fixed bounds not refreshed", 1e3 * static_cast<double>(kTunedMargin_m))
               : ", defaults");
  }

 private:
  btRigidBody* add(const Vec3d& half_extents_m, double mass_kg, btScalar friction, const btTransform& at) {
    auto shape = std::make_unique<btBoxShape>(as_bullet(half_extents_m));
    if (tuned_) shape->setMargin(kTunedMargin_m);
    btVector3 inertia(0, 0, 0);
    if (mass_kg > 0) shape->calculateLocalInertia(static_cast<btScalar>(mass_kg), inertia);
    motions_.push_back(std::make_unique<btDefaultMotionState>(at));
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass_kg), motions_.back().get(), shape.get(),
                                                  inertia);
    // Bullet multiplies the two coefficients: the pair is to have that of the others.
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
  std::vector<std::unique_ptr<btBoxShape>> shapes_;
  std::vector<std::unique_ptr<btDefaultMotionState>> motions_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  btScalar step_s_;
  std::optional<Paddle> paddle_;
  bool tuned_;
  std::size_t cubes_;
  btRigidBody* rod_{nullptr};
  double time_s_{0};
};

}  // namespace

std::unique_ptr<Engine> make_bullet(const BoxScene& scene, const EngineOptions& options) {
  return std::make_unique<BulletEngine>(scene, options);
}

}  // namespace tactus::experiment
