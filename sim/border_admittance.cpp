#include "sim/border_admittance.h"

#include <cmath>

namespace tactus::sim {
namespace {

using physics::Body;
using physics::Contact;

constexpr std::uint32_t kNone = 0xffffffffu;
// A contact that presses gives way to an impulse by a hundred thousandth of what the lighter body would: as good as
// rigid over a cycle, and far from the limits of double where thirty follow each other.
constexpr double kFirmness = 1e5;
// A contact whose friction is further used up than this counts as sliding.
constexpr double kSticks = 0.95;

// K = L L^T in place, L below and on the diagonal; false where K is not positive.
bool factorise(Matrix6& k) noexcept {
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t m = 0; m < j; ++m)
      for (std::size_t i = j; i < 6; ++i) k[i][j] -= k[i][m] * k[j][m];
    if (!(k[j][j] > 0)) return false;
    k[j][j] = std::sqrt(k[j][j]);
    const double scale = 1 / k[j][j];
    for (std::size_t i = j + 1; i < 6; ++i) k[i][j] *= scale;
  }
  return true;
}

// x with L L^T x = b.
void solve(const Matrix6& l, Vector6& b) noexcept {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t m = 0; m < i; ++m) b[i] -= l[i][m] * b[m];
    b[i] /= l[i][i];
  }
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t m = i + 1; m < 6; ++m) b[i] -= l[m][i] * b[m];
    b[i] /= l[i][i];
  }
}

// X with L X = B, all columns at once.
void solve_lower(const Matrix6& l, Matrix6& b) noexcept {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t m = 0; m < i; ++m)
      for (std::size_t j = 0; j < 6; ++j) b[i][j] -= l[i][m] * b[m][j];
    const double scale = 1 / l[i][i];
    for (std::size_t j = 0; j < 6; ++j) b[i][j] *= scale;
  }
}

void add(Matrix6& to, const Matrix6& by) noexcept {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) to[i][j] += by[i][j];
}

// Of a free body, for twists of a point `d` before its centre: its velocity there is v + w x d.
Matrix6 inertia_of(const Body<double>& body, const Vec3d& d) noexcept {
  const SymMat3<double> own = rotate_diagonal(body.motion.pose.rotation, body.inertia);
  const double m = body.mass, dd = norm_squared(d);
  const Vec3d md = m * d;
  const double xx = own.xx + m * (dd - d.x * d.x), yy = own.yy + m * (dd - d.y * d.y),
               zz = own.zz + m * (dd - d.z * d.z);
  const double xy = own.xy - m * d.x * d.y, xz = own.xz - m * d.x * d.z, yz = own.yz - m * d.y * d.z;
  return {{{m, 0, 0, 0, md.z, -md.y},
           {0, m, 0, -md.z, 0, md.x},
           {0, 0, m, md.y, -md.x, 0},
           {0, -md.z, md.y, xx, xy, xz},
           {md.z, 0, -md.x, xy, yy, yz},
           {-md.y, md.x, 0, xz, yz, zz}}};
}

// What the contact holds, as if it were that much inertia: the sum of J J^T over the directions that it holds.
Matrix6 firmness_of(const Contact<double>& contact, std::span<const Body<double>> bodies,
                    const Vec3d& centre) noexcept {
  const Body<double>& a = bodies[contact.slot_a];
  const double inverse_mass = 1 / a.mass + (contact.b_fixed ? 0 : 1 / bodies[contact.slot_b].mass);
  const double firm = kFirmness / inverse_mass;
  Vec3d friction;
  double pressed = 0;
  for (std::uint32_t i = 0; i < contact.count; ++i)
    friction += contact.points[i].total_friction, pressed += contact.points[i].total_normal_impulse;
  const bool sticks = norm(friction) < kSticks * contact.friction * pressed;
  const auto [t1, t2] = tangents_of(contact.normal);
  const Vec3d directions[3] = {contact.normal, t1, t2};
  Matrix6 sum{};
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const auto& point = contact.points[i];
    if (!(point.total_normal_impulse > 0)) continue;
    const Vec3d r = a.motion.pose.position + point.from_a - centre;
    for (int d = 0; d < (sticks ? 3 : 1); ++d) {
      const Vec3d& n = directions[d];
      const Vec3d turn = cross(r, n);
      const Vector6 row{n.x, n.y, n.z, turn.x, turn.y, turn.z};
      for (std::size_t k = 0; k < 6; ++k) {
        const double scaled = firm * row[k];
        for (std::size_t l = 0; l < 6; ++l) sum[k][l] += scaled * row[l];
      }
    }
  }
  return sum;
}

// What is felt of `inertia` through a contact of that firmness: both in series, G - G (G + I)^-1 G. With G + I = L L^T
// and Y = L^-1 G that is G - Y^T Y.
Matrix6 felt_through(const Matrix6& firmness, const Matrix6& inertia) noexcept {
  Matrix6 both = firmness, felt = firmness, y = firmness;
  add(both, inertia);
  if (!factorise(both)) return {};
  solve_lower(both, y);
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) felt[i][j] -= y[k][i] * y[k][j];
  return felt;
}

physics::Admittance<double> invert(Matrix6 inertia) noexcept {
  if (!factorise(inertia)) return {};
  Matrix6 w;
  for (std::size_t j = 0; j < 6; ++j) {
    Vector6 column{};
    column[j] = 1;
    solve(inertia, column);
    for (std::size_t i = 0; i < 6; ++i) w[i][j] = column[i];
  }
  physics::Admittance<double> result;
  result.linear = {w[0][0], w[1][1], w[2][2], w[1][0], w[2][0], w[2][1]};
  result.angular = {w[3][3], w[4][4], w[5][5], w[4][3], w[5][3], w[5][4]};
  for (std::size_t i = 0; i < 3; ++i) result.crossed[i] = {w[3][i], w[4][i], w[5][i]};
  return result;
}

}  // namespace

BorderAdmittance::BorderAdmittance(std::uint32_t max_bodies, std::uint32_t max_contacts)
    : first_(max_bodies + 1), links_(2 * std::size_t{max_contacts}), found_(max_bodies, 0) {
  reached_.reserve(kMostBodies);
}

void BorderAdmittance::index(std::span<const Contact<double>> contacts, std::span<const Body<double>> bodies) noexcept {
  TACTUS_CHECK(bodies.size() < first_.size() && 2 * contacts.size() <= links_.size(), bodies.size(), contacts.size());
  contacts_ = contacts, bodies_ = bodies;
  std::fill(first_.begin(), first_.end(), 0u);
  std::uint32_t count = 0;
  for (const auto& contact : contacts) {
    ++first_[contact.slot_a], ++count;
    if (!contact.b_fixed) ++first_[contact.slot_b], ++count;
  }
  // Ends of the bodies' links; filling backwards turns them into the starts and keeps the order.
  for (std::size_t slot = 1; slot < first_.size(); ++slot) first_[slot] += first_[slot - 1];
  for (std::size_t c = contacts.size(); c-- > 0;) {
    links_[--first_[contacts[c].slot_a]] = static_cast<std::uint32_t>(c);
    if (!contacts[c].b_fixed) links_[--first_[contacts[c].slot_b]] = static_cast<std::uint32_t>(c);
  }
}

std::span<const std::uint32_t> BorderAdmittance::contacts_of(std::uint32_t slot) const noexcept {
  return {links_.data() + first_[slot], first_[slot + 1] - first_[slot]};
}

void BorderAdmittance::reach(std::uint32_t slot, std::uint32_t parent, std::uint32_t contact,
                             const Vec3d& centre) noexcept {
  found_[slot] = search_;
  reached_.push_back(
      {slot, parent, contact, inertia_of(bodies_[slot], bodies_[slot].motion.pose.position - centre), {}, {}});
}

// The bodies that the asked one hangs together with, and the inertia that each shows to its parent's side.
void BorderAdmittance::collect(std::uint32_t slot, std::span<const std::uint8_t> members) noexcept {
  ++search_;
  reached_.clear();
  const Vec3d centre = bodies_[slot].motion.pose.position;
  reach(slot, kNone, kNone, centre);
  for (std::uint32_t head = 0; head < reached_.size(); ++head)
    for (const std::uint32_t c : contacts_of(reached_[head].slot)) {
      const Contact<double>& contact = contacts_[c];
      if (contact.b_fixed) {
        add(reached_[head].inertia, firmness_of(contact, bodies_, centre));
        continue;
      }
      const std::uint32_t other = contact.slot_a == reached_[head].slot ? contact.slot_b : contact.slot_a;
      if (members[other] == 0 && found_[other] != search_ && reached_.size() < kMostBodies && contact.touching())
        reach(other, head, c, centre);
    }
  for (std::size_t i = reached_.size(); i-- > 1;) {
    Reached& from = reached_[i];
    from.firmness = firmness_of(contacts_[from.contact], bodies_, centre);
    add(reached_[from.parent].inertia, felt_through(from.firmness, from.inertia));
  }
}

physics::Admittance<double> BorderAdmittance::find(std::uint32_t slot, std::span<const std::uint8_t> members) noexcept {
  collect(slot, members);
  return invert(reached_[0].inertia);
}

// From the body outwards: what hangs on a contact of firmness G follows its parent by (G + I)^-1 G.
double BorderAdmittance::apply(std::uint32_t slot, std::span<const std::uint8_t> members, const Wrenchd& impulse,
                               std::span<Body<double>> bodies) noexcept {
  collect(slot, members);
  const Vec3d centre = bodies_[slot].motion.pose.position;
  double gained_J = 0;
  for (std::size_t i = 0; i < reached_.size(); ++i) {
    Reached& to = reached_[i];
    if (i == 0) {
      to.change = {impulse.force.x,  impulse.force.y,  impulse.force.z,
                   impulse.torque.x, impulse.torque.y, impulse.torque.z};
    } else {
      const Vector6 pushed = reached_[to.parent].change;
      for (std::size_t k = 0; k < 6; ++k) {
        to.change[k] = 0;
        for (std::size_t l = 0; l < 6; ++l) to.change[k] += to.firmness[k][l] * pushed[l];
      }
      add(to.inertia, to.firmness);
    }
    if (!factorise(to.inertia)) break;
    solve(to.inertia, to.change);
    Body<double>& body = bodies[to.slot];
    const Vec3d turn{to.change[3], to.change[4], to.change[5]};
    gained_J -= kinetic_energy(body);
    body.motion.velocity.linear +=
        Vec3d{to.change[0], to.change[1], to.change[2]} + cross(turn, body.motion.pose.position - centre);
    body.motion.velocity.angular += turn;
    gained_J += kinetic_energy(body);
  }
  return gained_J;
}

}  // namespace tactus::sim
