#include "sim/exchange/apparent_inertia.h"

#include <algorithm>
#include <cmath>

namespace tactus::sim {
namespace {

using physics::Body;
using physics::Contact;
using physics::Joint;
using physics::JointKind;
using physics::JointState;
using physics::SlotIndex;

constexpr std::uint32_t kNone = 0xffffffffu;  // no parent, no link: of the queried body
// Ratio of the friction force to its limit, or of a motor's effort to its largest effort, 0 to 1: from this ratio on a
// contact counts as sliding, a motor as overcome.
constexpr double kSticks = 0.95;

// Cholesky factorisation K = L L^T, in place, L in the lower triangle. False if K is not positive definite.
bool factorise(Matrix6& k) noexcept {
#pragma GCC unroll 6
  for (std::size_t j = 0; j < 6; ++j) {
#pragma GCC unroll 6
    for (std::size_t m = 0; m < j; ++m)
#pragma GCC unroll 6
      for (std::size_t i = j; i < 6; ++i) k[i][j] -= k[i][m] * k[j][m];
    if (!(k[j][j] > 0)) return false;
    k[j][j] = std::sqrt(k[j][j]);
    const double scale = 1 / k[j][j];
#pragma GCC unroll 6
    for (std::size_t i = j + 1; i < 6; ++i) k[i][j] *= scale;
  }
  return true;
}

// Solves L x = b, in place.
void solve_lower(const Matrix6& l, Vector6& b) noexcept {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t m = 0; m < i; ++m) b[i] -= l[i][m] * b[m];
    b[i] /= l[i][i];
  }
}

// Solves L L^T x = b, in place.
void solve(const Matrix6& l, Vector6& b) noexcept {
  solve_lower(l, b);
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t m = i + 1; m < 6; ++m) b[i] -= l[m][i] * b[m];
    b[i] /= l[i][i];
  }
}

// Solves L X = B, in place.
void solve_lower(const Matrix6& l, Matrix6& b) noexcept {
#pragma GCC unroll 6
  for (std::size_t i = 0; i < 6; ++i) {
#pragma GCC unroll 6
    for (std::size_t m = 0; m < i; ++m)
      for (std::size_t j = 0; j < 6; ++j) b[i][j] -= l[i][m] * b[m][j];
    const double scale = 1 / l[i][i];
    for (std::size_t j = 0; j < 6; ++j) b[i][j] *= scale;
  }
}

void add(Vector6& to, const Vector6& by) noexcept {
  for (std::size_t i = 0; i < 6; ++i) to[i] += by[i];
}
void add(Matrix6& to, const Matrix6& by) noexcept {
  for (std::size_t i = 0; i < 6; ++i) add(to[i], by[i]);
}

Vector6 difference(const Vector6& a, const Vector6& b) noexcept {
  Vector6 result;
  for (std::size_t i = 0; i < 6; ++i) result[i] = a[i] - b[i];
  return result;
}

Vector6 product(const Matrix6& m, const Vector6& v) noexcept {
  Vector6 result{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) result[i] += m[i][j] * v[j];
  return result;
}

// Spatial inertia about a point, of a mass with the first moment `moment` and the second moment `second` about it.
Matrix6 inertia_of(double mass, const Vec3d& moment, const SymMat3d& second) noexcept {
  const auto& [x, y, z] = moment;
  const SymMat3d& t = second;
  return {{{mass, 0, 0, 0, z, -y},
           {0, mass, 0, -z, 0, x},
           {0, 0, mass, y, -x, 0},
           {0, -z, y, t.xx, t.xy, t.xz},
           {z, 0, -x, t.xy, t.yy, t.yz},
           {-y, x, 0, t.xz, t.yz, t.zz}}};
}

// Second moment of a point mass at r: mass (|r|^2 - r r^T).
SymMat3d second_moment(double mass, const Vec3d& r) noexcept {
  const Vec3d m = mass * r;
  const double rr = dot(m, r);
  return {rr - m.x * r.x, rr - m.y * r.y, rr - m.z * r.z, -m.x * r.y, -m.x * r.z, -m.y * r.z};
}

// Spatial inertia of a free body about the point centre - d; the centre's velocity is v + w x d.
Matrix6 inertia_of(const Body& body, const Vec3d& d) noexcept {
  const SymMat3d own = rotate_diagonal(body.motion.pose.rotation, body.inertia);
  return inertia_of(body.mass, body.mass * d, own + second_moment(body.mass, d));
}

// The body's twist at the point centre - d.
Vector6 at_point(const Twistd& of_centre, const Vec3d& d) noexcept {
  const Vec3d &w = of_centre.angular, v = of_centre.linear - cross(w, d);
  return {v.x, v.y, v.z, w.x, w.y, w.z};
}

Twistd mean_between(const Posed& start, const Posed& end, double step_s) noexcept {
  const double rate = 1 / step_s;
  return {(end.position - start.position) * rate,
          small_rotation_vector(end.rotation * conjugate(start.rotation)) * rate};
}

// Adds a constraint of stiffness `stiffness` along the screw s = (along, turn): stiffness s s^T. `turn`: moment of
// `along` about the centre.
void hold(Matrix6& sum, double stiffness, const Vec3d& along, const Vec3d& turn) noexcept {
  const Vector6 row{along.x, along.y, along.z, turn.x, turn.y, turn.z};
  for (std::size_t k = 0; k < 6; ++k) {
    const double scaled = stiffness * row[k];
    for (std::size_t l = 0; l < 6; ++l) sum[k][l] += scaled * row[l];
  }
}

double inverse_mass_of(std::span<const Body> bodies, SlotIndex slot) noexcept {
  return slot == ApparentInertia::kStatic ? 0 : 1 / bodies[number_of(slot)].mass;
}
double inverse_inertia_of(std::span<const Body> bodies, SlotIndex slot) noexcept {
  if (slot == ApparentInertia::kStatic) return 0;
  const Vec3d& i = bodies[number_of(slot)].inertia;
  return 1 / std::min({i.x, i.y, i.z});
}

// Velocity of B's contact point relative to A's, m/s.
Vec3d slip_of(const Contact& contact, const physics::ContactPoint& point, std::span<const Body> bodies) noexcept {
  const Twistd& a = bodies[contact.slot_a].motion.velocity;
  const Vec3d of_a = a.linear + cross(a.angular, point.from_a);
  if (contact.b_fixed) return -of_a;
  const Twistd& b = bodies[contact.slot_b].motion.velocity;
  return b.linear + cross(b.angular, point.from_b) - of_a;
}

// G of a contact, as an inertia: added_inertia times the reduced mass, times the sum of J J^T over the constrained
// directions. The impulse that would stop the present motion is added to the load of the last step: the contact
// constrains if it then still presses, and sticks if its friction stays within the friction disk.
Matrix6 stiffness_of_contact(const Contact& contact, double added_inertia, std::span<const Body> bodies,
                             const Vec3d& centre) noexcept {
  const Body& a = bodies[contact.slot_a];
  const SlotIndex slot_b = contact.b_fixed ? ApparentInertia::kStatic : SlotIndex{contact.slot_b};
  const double mass_of_both = 1 / (1 / a.mass + inverse_mass_of(bodies, slot_b));
  const double stiffness = added_inertia * mass_of_both;
  Vec3d friction, slip;
  double pressed = 0, points = 0;
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const auto& point = contact.points[i];
    if (!(point.total_normal_impulse > 0)) continue;
    friction += point.total_friction;
    pressed += point.total_normal_impulse;
    slip += slip_of(contact, point, bodies);
    points += 1;
  }
  const Vec3d stopping = points > 0 ? slip * (-mass_of_both / points) : Vec3d{};
  const double pull = dot(contact.normal, stopping);
  if (!(pressed + std::min(0.0, pull) > 0)) return {};
  const bool sticks = norm(friction + stopping - pull * contact.normal) < kSticks * contact.friction * pressed;
  // A sticking point constrains all three directions, as a point mass there.
  double mass = 0;
  Vec3d moment;
  SymMat3d second;
  Matrix6 sum{};
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const auto& point = contact.points[i];
    if (!(point.total_normal_impulse > 0)) continue;
    const Vec3d r = a.motion.pose.position + point.from_a - centre;
    if (sticks) {
      mass += stiffness;
      moment += stiffness * r;
      second = second + second_moment(stiffness, r);
    } else
      hold(sum, stiffness, contact.normal, cross(r, contact.normal));
  }
  return sticks ? inertia_of(mass, moment, second) : sum;
}

// True if the joint also constrains its coordinate: at a limit under load, or by a motor that is not overcome.
bool holds_coordinate(const Joint& joint, const JointState& state) noexcept {
  if (joint.kind == JointKind::kDistance)
    return joint.low == joint.high || state.effort.lower != 0 || state.effort.upper != 0;
  if (joint.limited && (state.effort.lower != 0 || state.effort.upper != 0)) return true;
  return joint.driven && std::abs(state.effort.drive) < kSticks * joint.motor_effort;
}

// The inertia and momentum that a body (I, p) presents to its parent through a link of stiffness G. The body moves by
// (I + G) v = p + G v_parent and acts on the parent with G (v - v_parent). With I + G = L L^T, Y = L^-1 G and
// z = L^-1 p this is Y^T z - (G - Y^T Y) v_parent.
struct SeriesResponse {
  Matrix6 inertia{};
  Vector6 momentum{};
};
SeriesResponse series_inertia(const Matrix6& constraint_stiffness, const Matrix6& inertia,
                              const Vector6& momentum) noexcept {
  Matrix6 both = constraint_stiffness, y = constraint_stiffness;
  add(both, inertia);
  if (!factorise(both)) return {};
  solve_lower(both, y);
  Vector6 z = momentum;
  solve_lower(both, z);
  SeriesResponse response{constraint_stiffness, {}};
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t i = 0; i < 6; ++i) {
      response.momentum[i] += y[k][i] * z[k];
      for (std::size_t j = 0; j < 6; ++j) response.inertia[i][j] -= y[k][i] * y[k][j];
    }
  return response;
}

physics::Admittance invert(Matrix6 inertia) noexcept {
  if (!factorise(inertia)) return {};
  Matrix6 w;
  for (std::size_t j = 0; j < 6; ++j) {
    Vector6 column{};
    column[j] = 1;
    solve(inertia, column);
    for (std::size_t i = 0; i < 6; ++i) w[i][j] = column[i];
  }
  physics::Admittance result;
  result.linear = {w[0][0], w[1][1], w[2][2], w[1][0], w[2][0], w[2][1]};
  result.angular = {w[3][3], w[4][4], w[5][5], w[4][3], w[5][3], w[5][4]};
  for (std::size_t i = 0; i < 3; ++i) result.crossed[i] = {w[3][i], w[4][i], w[5][i]};
  return result;
}

}  // namespace

ApparentInertia::ApparentInertia(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints)
    : first_(max_bodies + 1), links_(2 * (std::size_t{max_contacts} + max_joints)), found_(max_bodies, 0) {
  joints_.reserve(max_joints);
  immovable_.reserve(max_bodies);
  visited_.reserve(kMaxBodies);
}

// Unbroken joints whose bodies are both awake; A may be the world.
void ApparentInertia::find_joints(const physics::World& world) noexcept {
  joints_.clear();
  const auto* effect = world.effects().find<physics::Joints>();
  if (effect == nullptr) return;
  for (std::size_t k = 0; k < effect->joints().size(); ++k) {
    const Joint& joint = effect->joints()[k];
    const auto a = joint.a == kNoBody ? std::nullopt : world.slot_of(joint.a), b = world.slot_of(joint.b);
    if (effect->states()[k].broken != 0 || !b || (joint.a != kNoBody && !a)) continue;
    joints_.push_back({.a = a.value_or(kStatic), .b = *b, .joint = &joint, .state = &effect->states()[k]});
  }
}

template <class F>
void ApparentInertia::for_each_link(F&& f) const noexcept {
  std::uint32_t link = 0;
  for (const auto& contact : contacts_)
    f(link++, SlotIndex{contact.slot_a}, contact.b_fixed ? kStatic : SlotIndex{contact.slot_b});
  for (const JointLink& joint : joints_) f(link++, joint.a, joint.b);
}

void ApparentInertia::index(const physics::World& world, double added_inertia, double step_s) noexcept {
  added_inertia_ = added_inertia;
  step_s_ = step_s;
  contacts_ = world.contacts();
  bodies_ = world.bodies();
  starts_ = world.last_poses();
  find_joints(world);
  TACTUS_CHECK(bodies_.size() < first_.size() && 2 * (contacts_.size() + joints_.size()) <= links_.size(),
               bodies_.size(), contacts_.size() + joints_.size());
  immovable_.assign(bodies_.size(), 0);
  if (const auto* kinematics = world.effects().find<physics::ScriptedMotion>())
    for (const auto& script : kinematics->scripts())
      if (const auto slot = world.slot_of(script.id)) immovable_[number_of(*slot)] = 1;
  std::fill(first_.begin(), first_.end(), 0u);
  const auto count = [&](SlotIndex slot) noexcept {
    if (slot != kStatic) ++first_[number_of(slot) + 1];
  };
  for_each_link([&](std::uint32_t, SlotIndex a, SlotIndex b) noexcept {
    count(a);
    count(b);
  });
  for (std::size_t slot = 1; slot < first_.size(); ++slot) first_[slot] += first_[slot - 1];
  // Filling advances each start to the start of the next slot; the copy shifts them back.
  const auto add_link = [&](SlotIndex slot, const Link& link) noexcept {
    if (slot != kStatic) links_[first_[number_of(slot)]++] = link;
  };
  for_each_link([&](std::uint32_t link, SlotIndex a, SlotIndex b) noexcept {
    add_link(a, {link, b});
    add_link(b, {link, a});
  });
  std::copy_backward(first_.begin(), first_.end() - 1, first_.end());
  first_[0] = 0;
}

std::span<const ApparentInertia::Link> ApparentInertia::links_of(SlotIndex slot) const noexcept {
  const std::uint32_t i = number_of(slot);
  return {links_.data() + first_[i], first_[i + 1] - first_[i]};
}

Matrix6 ApparentInertia::stiffness_of_joint(const JointLink& link, const Vec3d& centre) const noexcept {
  const Joint& joint = *link.joint;
  const double stiffness = added_inertia_ / (inverse_mass_of(bodies_, link.a) + inverse_mass_of(bodies_, link.b));
  const double firm_turn = added_inertia_ / (inverse_inertia_of(bodies_, link.a) + inverse_inertia_of(bodies_, link.b));
  const Posed at_a = link.a == kStatic ? joint.a_from_joint : body(link.a).motion.pose * joint.a_from_joint;
  const Posed at_b = body(link.b).motion.pose * joint.b_from_joint;
  const Vec3d r = at_b.position - centre;
  const bool coordinate = holds_coordinate(joint, *link.state);
  Matrix6 sum{};
  if (joint.kind == JointKind::kDistance) {
    const Vec3d n = normalized_or(at_b.position - at_a.position, Vec3d{0, 0, 1});
    if (coordinate) hold(sum, stiffness, n, cross(r, n));
    return sum;
  }
  const bool slides = joint.kind == JointKind::kSlider && !coordinate;
  const bool turns = joint.kind == JointKind::kHinge && !coordinate;
  const Vec3d axes[3] = {rotate(at_a.rotation, Vec3d{1, 0, 0}), rotate(at_a.rotation, Vec3d{0, 1, 0}),
                         rotate(at_a.rotation, Vec3d{0, 0, 1})};
  for (int k = 0; k < 3; ++k) {
    if (k < 2 || !slides) hold(sum, stiffness, axes[k], cross(r, axes[k]));
    if (joint.kind != JointKind::kBall && (k < 2 || !turns)) hold(sum, firm_turn, {}, axes[k]);
  }
  return sum;
}

Matrix6 ApparentInertia::constraint_stiffness_of(std::uint32_t link, const Vec3d& centre) const noexcept {
  if (link < contacts_.size()) return stiffness_of_contact(contacts_[link], added_inertia_, bodies_, centre);
  return stiffness_of_joint(joints_[link - contacts_.size()], centre);
}

// Over the last step; the present velocity of a body that was added since.
Twistd ApparentInertia::mean_velocity(SlotIndex slot) const noexcept {
  const Body& moved = body(slot);
  const Posed& start = starts_[number_of(slot)];
  return is_finite(start) ? mean_between(start, moved.motion.pose, step_s_) : moved.motion.velocity;
}

Twistd ApparentInertia::off_mean(SlotIndex slot) const noexcept {
  return body(slot).motion.velocity - mean_velocity(slot);
}

bool ApparentInertia::is_new(std::uint32_t link) const noexcept {
  return link < contacts_.size() && contacts_[link].least_separation() > 0.0;
}

void ApparentInertia::visit(SlotIndex slot, std::uint32_t parent, std::uint32_t link, const Vec3d& centre) noexcept {
  found_[number_of(slot)] = search_;
  const Vec3d d = body(slot).motion.pose.position - centre;
  const Matrix6 inertia = inertia_of(body(slot), d);
  const Vector6 mean = at_point(mean_velocity(slot), d);
  Vector6 reference = mean;
  if (parent != kNone) {
    const Visited& from = visited_[parent];
    reference = is_new(link) ? from.reference : difference(mean, difference(from.mean, from.reference));
  }
  visited_.push_back({.slot = slot,
                      .parent = parent,
                      .link = link,
                      .mean = mean,
                      .reference = reference,
                      .inertia = inertia,
                      .constraint_stiffness = {},
                      .momentum = product(inertia, difference(at_point(body(slot).motion.velocity, d), reference))});
}

// Two compounds touch by several contacts, which are consecutive; `from` was reached by the first that touches.
void ApparentInertia::add_other_parts(Visited& from, const Vec3d& centre) const noexcept {
  for (std::uint32_t next = from.link + 1; next < contacts_.size(); ++next) {
    if (contacts_[next].key.of_bodies() != contacts_[from.link].key.of_bodies()) return;
    if (contacts_[next].touching()) add(from.constraint_stiffness, constraint_stiffness_of(next, centre));
  }
}

// Collects the bodies connected to the queried one, then eliminates them from the far end inwards, each into its
// parent.
void ApparentInertia::collect(SlotIndex slot, std::span<const std::uint8_t> members) noexcept {
  ++search_;
  visited_.clear();
  const Vec3d centre = body(slot).motion.pose.position;
  visit(slot, kNone, kNone, centre);
  for (std::uint32_t head = 0; head < visited_.size(); ++head)
    for (const auto& [link, other] : links_of(visited_[head].slot)) {
      if (other == kStatic || is_immovable(other)) {
        const Matrix6 constraint_stiffness = constraint_stiffness_of(link, centre);
        Visited& held = visited_[head];
        Vector6 given = difference(held.mean, held.reference);
        if (other != kStatic) add(given, at_point(off_mean(other), body(other).motion.pose.position - centre));
        add(held.inertia, constraint_stiffness);
        add(held.momentum, product(constraint_stiffness, given));
      } else if (members[number_of(other)] == 0 && found_[number_of(other)] != search_ &&
                 visited_.size() < kMaxBodies && (link >= contacts_.size() || contacts_[link].touching())) {
        visit(other, head, link, centre);
      }
    }
  for (std::size_t i = visited_.size(); i-- > 1;) {
    Visited& from = visited_[i];
    from.constraint_stiffness = constraint_stiffness_of(from.link, centre);
    add_other_parts(from, centre);
    Visited& to = visited_[from.parent];
    const SeriesResponse response = series_inertia(from.constraint_stiffness, from.inertia, from.momentum);
    add(to.inertia, response.inertia);
    add(to.momentum, response.momentum);
  }
}

OutsideAnswer ApparentInertia::find(SlotIndex slot, std::span<const std::uint8_t> members) noexcept {
  if (is_immovable(slot)) return {body(slot).motion.velocity, {}};
  collect(slot, members);
  const Vector6& p = visited_[0].momentum;
  const physics::Admittance w = invert(visited_[0].inertia);
  const Twistd mean = mean_velocity(slot), kept = w * Wrenchd{{p[0], p[1], p[2]}, {p[3], p[4], p[5]}};
  return {mean + kept, w};
}

physics::Admittance ApparentInertia::free_admittance(SlotIndex slot) const noexcept {
  return is_immovable(slot) ? physics::Admittance{} : invert(inertia_of(body(slot), {}));
}

}  // namespace tactus::sim
