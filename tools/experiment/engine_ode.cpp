// ODE, as its package is built: double precision, the quick step (projected Gauss-Seidel), one thread.
#include <fmt/format.h>
#include <ode/ode.h>

#include <algorithm>
#include <array>

#include "tools/experiment/engine.h"

namespace tactus::experiment {
namespace {

constexpr int kPointsPerPair = 4;
// Tuned: half the sweeps of the default, and a broad phase by sorting, which keeps its memory.
constexpr int kTunedIterations = 10;

struct OdeLibrary {  // its set-up counts nothing itself: once a process
  OdeLibrary() { dInitODE2(0); }
  ~OdeLibrary() { dCloseODE(); }
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;
};

Vec3d from_ode(const dReal* v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

class OdeEngine final : public Engine {
 public:
  OdeEngine(const BoxScene& scene, const EngineOptions& options)
      : step_s_(scene.step_s), friction_(scene.friction), paddle_(scene.paddle), tuned_(options.tuned) {
    static const OdeLibrary library;
    world_ = dWorldCreate();
    space_ = tuned_ ? dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ) : dHashSpaceCreate(nullptr);
    joints_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, 0, 0, -scene.gravity_m_per_s2);
    dWorldSetAutoDisableFlag(world_, 0);
    if (tuned_) dWorldSetQuickStepNumIterations(world_, kTunedIterations);
    for (const Cube& cube : scene.cubes) cubes_.push_back(add_cube(cube));
    for (const Wall& wall : scene.walls) {
      const Vec3d size = 2.0 * wall.half_extents_m;
      dGeomSetPosition(dCreateBox(space_, size.x, size.y, size.z), wall.position.x, wall.position.y, wall.position.z);
    }
    if (paddle_) add_rod();
  }

  ~OdeEngine() override {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  OdeEngine(const OdeEngine&) = delete;
  OdeEngine& operator=(const OdeEngine&) = delete;

  void step() override {
    if (rod_ != nullptr) {
      // ODE moves a kinematic body by its velocity: that which takes it from where it is to where it is to be.
      const Vec3d way = paddle_->position_at(time_s_ + step_s_) - from_ode(dBodyGetPosition(rod_));
      dBodySetLinearVel(rod_, way.x / step_s_, way.y / step_s_, way.z / step_s_);
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
      states.push_back({from_ode(dBodyGetPosition(body)), from_ode(dBodyGetLinearVel(body))});
    return states;
  }

  std::string settings() const override {
    return fmt::format("{} precision, quick step, {} iterations, {} points a pair, {}",

                       sizeof(dReal) == sizeof(double) ? "double" : "single", dWorldGetQuickStepNumIterations(world_),
                       kPointsPerPair, tuned_ ? "sweep-and-prune space" : "hash space, defaults");
  }

 private:
  dBodyID add_cube(const Cube& cube) {
    const dBodyID body = dBodyCreate(world_);
    dMass mass;
    dMassSetBoxTotal(&mass, cube.mass_kg, cube.edge_m, cube.edge_m, cube.edge_m);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, cube.position.x, cube.position.y, cube.position.z);
    const dQuaternion q{cube.rotation.w, cube.rotation.x, cube.rotation.y, cube.rotation.z};
    dBodySetQuaternion(body, q);
    dGeomSetBody(dCreateBox(space_, cube.edge_m, cube.edge_m, cube.edge_m), body);
    return body;
  }

  void add_rod() {
    rod_ = dBodyCreate(world_);
    const Vec3d size = 2.0 * paddle_->half_extents_m, at = paddle_->position_at(0);
    dBodySetPosition(rod_, at.x, at.y, at.z);
    dBodySetKinematic(rod_);
    dGeomSetBody(dCreateBox(space_, size.x, size.y, size.z), rod_);
  }

  void collide(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (body_a == nullptr && body_b == nullptr) return;
    std::array<dContact, kPointsPerPair> contacts;
    const int count = dCollide(a, b, kPointsPerPair, &contacts[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      dContact& contact = contacts[static_cast<std::size_t>(i)];
      contact.surface = {};
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = friction_;
      dJointAttach(dJointCreateContact(world_, joints_, &contact), body_a, body_b);
      facts_.penetration_m = std::max(facts_.penetration_m, static_cast<double>(contact.geom.depth));
    }
    facts_.contacts += count;
    facts_.touching_pairs += count > 0 ? 1 : 0;  // ODE finds nothing before it overlaps
  }

  dWorldID world_{};
  dSpaceID space_{};
  dJointGroupID joints_{};
  double step_s_, friction_;
  std::optional<Paddle> paddle_;
  bool tuned_;
  std::vector<dBodyID> cubes_;
  dBodyID rod_{nullptr};
  Measurement facts_;  // of the last step, but for the speed
  double time_s_{0};
};

}  // namespace

std::unique_ptr<Engine> make_ode(const BoxScene& scene, const EngineOptions& options) {
  return std::make_unique<OdeEngine>(scene, options);
}

}  // namespace tactus::experiment
