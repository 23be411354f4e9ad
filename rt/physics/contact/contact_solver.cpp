#include "rt/physics/contact/contact_solver.h"

#include <algorithm>
#include <bit>

#include "rt/physics/contact/find_contacts.h"

namespace tactus::physics {
namespace {

// A row takes a few tenths of a microsecond in a sweep, handing work to another thread about one.
constexpr std::uint32_t kMinRows = 8;
// The loops over bodies do little work per body, but a body just solved by another thread is slow to read; so each
// thread continues with the bodies of its own contacts.
constexpr std::uint32_t kMinBodies = 128;

// Impact: in one sub-step the impulses change a body's velocity by more than this share of the push speed. Below it the
// excess energy is small, and the check would cost more than a sweep.
constexpr double kImpactShare = 0.1;

template <class V>
void scale_lane(ContactRow<V>& row, int lane, LaneOf<V> factor) noexcept {
  const auto scale = [&](V& x) noexcept { set_lane(x, lane, factor * lane_of(x, lane)); };
  for (std::uint32_t i = 0; i < row.points; ++i) {
    scale(row.normal_impulse[i]);
    scale(row.tangent_impulse[0][i]);
    scale(row.tangent_impulse[1][i]);
  }
}

bool presses(const Contact& contact) noexcept {
  for (std::uint32_t i = 0; i < contact.count; ++i)
    if (!contact.points[i].redundant && (contact.points[i].normal_impulse > 0.0 || contact.points[i].separation <= 0.0))
      return true;
  return false;
}

// How many contacts two bodies' solved points would fill, at least 1 (softness.h). Counts those of contacts that press.
std::uint32_t share_among(std::span<const Contact> of_pair) noexcept {
  if (of_pair.size() == 1) return 1;
  std::uint32_t points = 0;
  for (const Contact& contact : of_pair) {
    if (!presses(contact)) continue;
    for (std::uint32_t i = 0; i < contact.count; ++i) points += contact.points[i].redundant ? 0 : 1;
  }
  return std::max(1u, (points + kMaxManifoldPoints - 1) / kMaxManifoldPoints);
}

template <class V>
void assign(ContactRow<V>& row, std::uint32_t lane, std::uint32_t contact, std::uint32_t share) noexcept {
  row.contact[lane] = contact;
  set_lane(row.share, static_cast<int>(lane), static_cast<LaneOf<V>>(share));
  row.any_shared |= share > 1 ? 1 : 0;
}

}  // namespace

template <class T, int kWidth>
ContactSolver<T, kWidth>::ContactSolver(const Capacities& capacities)
    : colours_(capacities),
      before_(capacities.bodies),
      accumulated_delta_v_(capacities.bodies),
      gate_(capacities.bodies) {
  // Every colour may end with one partly filled row.
  rows_.all = BoundedVector<ContactRow<V>>(
      std::min(capacities.contacts, capacities.contacts / kWidth + 2 * ContactColours::kColours));
  singles_.all = BoundedVector<ContactRow<T>>(capacities.contacts);
}

// Assigns each colour its rows, from `row` on. Rows with empty lanes are cleared.
template <class T, int kWidth>
std::uint32_t ContactSolver<T, kWidth>::place_colours(const ContactColours::Counts& counts, std::uint32_t row,
                                                      Starts& starts) noexcept {
  for (std::uint32_t colour = 0; colour < ContactColours::kColours; ++colour) {
    const std::uint32_t count = counts.in(colour), rows = (count + kWidth - 1) / kWidth;
    starts[colour] = row;
    rows_.all.resize(row + rows);
    for (std::uint32_t r = row; r < row + rows; ++r) {
      const std::uint32_t left = count - (r - row) * kWidth;
      if (left < kWidth) rows_.all[r] = ContactRow<V>{};
      rows_.all[r].used = std::min<std::uint32_t>(left, kWidth);
      rows_.all[r].points = rows_.all[r].any_shared = rows_.all[r].any_round = 0;
      rows_.all[r].rolling = 0;
    }
    row += rows;
  }
  return starts[ContactColours::kColours] = row;
}

// The first lane of each colour's contacts of four points, then of three, and so on.
template <class T, int kWidth>
auto ContactSolver<T, kWidth>::lanes_by_points(const ContactColours::Counts& counts, const Starts& starts) noexcept
    -> NextLanes {
  NextLanes next;
  for (std::uint32_t colour = 0; colour < ContactColours::kColours; ++colour) {
    std::uint32_t lane = starts[colour] * kWidth;
    for (std::uint32_t points = kMaxManifoldPoints; points > 0; --points) {
      next[colour][points - 1] = lane;
      lane += counts.of[colour][points - 1];
    }
  }
  return next;
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::prepare(std::span<const Contact> contacts, SolverBodies<T> bodies, double dt,
                                       const Executor& executor) noexcept {
  executor_ = executor;
  const auto count = static_cast<std::uint32_t>(bodies.motion.size());
  before_.resize(count);
  accumulated_delta_v_.resize(count);
  for_each_body([&](std::uint32_t i) noexcept { accumulated_delta_v_[i] = {}; });
  gate_.begin_step();
  given_is_known_ = false;
  order_ = {};
  sub_step_ = 0;
  colours_.assign(contacts, std::span<const SolverBody<T>>(bodies.motion));
  rows_.first_fixed = place_colours(colours_.moving(), 0, moving_);
  place_colours(colours_.fixed(), rows_.first_fixed, fixed_);
  singles_.first_fixed = colours_.moving().in(ContactColours::kLeftOver);
  singles_.all.resize(singles_.first_fixed + colours_.fixed().in(ContactColours::kLeftOver));
  for (auto& row : singles_.all) {
    row.used = 1;
    row.points = row.any_shared = row.any_round = 0;
    row.rolling = 0;
  }

  // Assigns each contact to a lane of its colour; then the rows are filled in their order. A row takes the time of its
  // contact with the most points, so those with as many share rows.
  NextLanes next_moving = lanes_by_points(colours_.moving(), moving_),
            next_fixed = lanes_by_points(colours_.fixed(), fixed_);
  std::uint32_t next_single = 0, next_fixed_single = singles_.first_fixed;
  std::size_t pair_end = 0;  // of the contacts of the same two bodies
  std::uint32_t share = 1;
  for (std::uint32_t k = 0; k < contacts.size(); ++k) {
    if (k == pair_end) {
      const auto of_pair = contacts_of_first_pair(contacts.subspan(k));
      pair_end += of_pair.size();
      share = share_among(of_pair);
    }
    const std::uint8_t colour = colours_.of(k);
    if (colour == ContactColours::kNotSolved) continue;
    if (colour == ContactColours::kLeftOver) {
      assign(singles_.all[(contacts[k].b_fixed ? next_fixed_single : next_single)++], 0, k, share);
      continue;
    }
    const std::uint32_t lane = (contacts[k].b_fixed ? next_fixed : next_moving)[colour][contacts[k].count - 1]++;
    assign(rows_.all[lane / kWidth], lane % kWidth, k, share);
  }
  for_each_row([contacts, bodies, dt](auto& row) noexcept {
    for (std::uint32_t lane = 0; lane < row.used; ++lane)
      fill_lane(row, static_cast<int>(lane), row.contact[lane], contacts[row.contact[lane]], bodies, dt);
    // Empty lanes read the bodies of the first lane and write nothing.
    for (auto lane = row.used; lane < static_cast<std::uint32_t>(row.kWidth); ++lane) {
      row.a[lane] = row.a[0];
      row.b[lane] = row.b[0];
    }
    complete(row);
  });
}

// Calls `f(begin, end)` on the rows: colour by colour if an executor shares the work, else on all at once. Colours are
// used from the first, so no rows follow an empty colour.
template <class T, int kWidth>
template <class F>
void ContactSolver<T, kWidth>::for_each_colour(const Starts& starts, F&& f) noexcept {
  if (!executor_.shares()) return f(starts[0], starts[ContactColours::kColours]);
  for (std::uint32_t colour = 0; colour < ContactColours::kColours && starts[colour] < starts[colour + 1]; ++colour)
    executor_.for_each_range(
        starts[colour + 1] - starts[colour], kMinRows,
        [&](std::uint32_t begin, std::uint32_t end) noexcept { f(starts[colour] + begin, starts[colour] + end); });
}

template <class T, int kWidth>
template <class F>
void ContactSolver<T, kWidth>::for_each_row(F&& f) noexcept {
  executor_.for_each_range(rows_.all.size(), kMinRows, [&](std::uint32_t k, std::uint32_t end) noexcept {
    for (; k < end; ++k) f(rows_.all[k]);
  });
  for (auto& row : singles_.all) f(row);
}
template <class T, int kWidth>
template <class F>
void ContactSolver<T, kWidth>::for_each_row(F&& f) const noexcept {
  executor_.for_each_range(rows_.all.size(), kMinRows, [&](std::uint32_t k, std::uint32_t end) noexcept {
    for (; k < end; ++k) f(rows_.all[k]);
  });
  for (const auto& row : singles_.all) f(row);
}

template <class T, int kWidth>
template <class F>
void ContactSolver<T, kWidth>::for_each_body(F&& f) noexcept {
  executor_.for_each_range(accumulated_delta_v_.size(), kMinBodies, [&](std::uint32_t i, std::uint32_t end) noexcept {
    for (; i < end; ++i) f(i);
  });
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::note_velocities(SolverBodies<T> bodies) noexcept {
  for_each_body([&](std::uint32_t i) noexcept { before_[i] = {bodies.motion[i].v, bodies.motion[i].w}; });
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::add_change(SolverBodies<T> bodies) noexcept {
  for_each_body([&](std::uint32_t i) noexcept {
    accumulated_delta_v_[i].linear += bodies.motion[i].v - before_[i].linear;
    accumulated_delta_v_[i].angular += bodies.motion[i].w - before_[i].angular;
  });
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::warm_start_freely(SolverBodies<T> bodies) noexcept {
  if (given_is_known_) {
    for_each_body([&](std::uint32_t i) noexcept {
      bodies.motion[i].v += accumulated_delta_v_[i].linear;
      bodies.motion[i].w += accumulated_delta_v_[i].angular;
    });
    return;
  }
  note_velocities(bodies);
  for_each_colour(moving_, [&](std::uint32_t k, std::uint32_t end) noexcept {
    for (; k < end; ++k) physics::warm_start<false>(rows_.all[k], bodies);
  });
  for (std::uint32_t k = 0; k < singles_.first_fixed; ++k) physics::warm_start<false>(singles_.all[k], bodies);
  for_each_colour(fixed_, [&](std::uint32_t k, std::uint32_t end) noexcept {
    for (; k < end; ++k) physics::warm_start<true>(rows_.all[k], bodies);
  });
  for (std::uint32_t k = singles_.first_fixed; k < singles_.all.size(); ++k)
    physics::warm_start<true>(singles_.all[k], bodies);
  add_change(bodies);
  given_is_known_ = true;
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::warm_start(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept {
  warm_start_freely(bodies);
  const T impact = static_cast<T>(kImpactShare) * rule.max_push_speed;
  if (holds_impact(impact)) hold_back_gain(bodies, impact);
}

template <class T, int kWidth>
bool ContactSolver<T, kWidth>::holds_impact(T impact_m_per_s) const noexcept {
  return std::any_of(accumulated_delta_v_.begin(), accumulated_delta_v_.end(),
                     [impact_m_per_s](const Twist<T>& given) noexcept { return is_impact(given, impact_m_per_s); });
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::hold_back_gain(SolverBodies<T> bodies, T impact_m_per_s) noexcept {
  if (!gate_.knows_islands()) {
    gate_.begin_islands(accumulated_delta_v_.size());
    const auto link = [&](const auto& row) noexcept {
      for (std::uint32_t lane = 0; lane < row.used; ++lane) gate_.link(bodies, row.a[lane], row.b[lane]);
    };
    for (std::uint32_t k = 0; k < rows_.first_fixed; ++k) link(rows_.all[k]);
    for (std::uint32_t k = 0; k < singles_.first_fixed; ++k) link(singles_.all[k]);
  }
  if (!gate_.hold_back(bodies, accumulated_delta_v_.span(), impact_m_per_s)) return;
  for_each_row([&](auto& row) noexcept {
    for (std::uint32_t lane = 0; lane < row.used; ++lane) {
      const T share = gate_.share(bodies, row.a[lane], row.b[lane]);
      if (share != T(1)) scale_lane(row, static_cast<int>(lane), share);
    }
  });
}

template <class T, int kWidth>
template <bool kBias, bool kFriction, bool kTotals>
void ContactSolver<T, kWidth>::sweep(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept {
  if constexpr (kBias) {
    order_ = {.normals_backwards = (sub_step_ & 1) != 0, .friction_backwards = (std::popcount(sub_step_) & 1) == 0};
    ++sub_step_;
  } else {
    order_.normals_backwards = !order_.normals_backwards;
  }
  note_velocities(bodies);
  for_each_colour(moving_, [&](std::uint32_t k, std::uint32_t end) noexcept {
    for (; k < end; ++k) solve<kBias, false, kFriction, kTotals>(rows_.all[k], bodies, rule, order_);
  });
  for (std::uint32_t k = 0; k < singles_.first_fixed; ++k)
    solve<kBias, false, kFriction, kTotals>(singles_.all[k], bodies, rule, order_);
  for_each_colour(fixed_, [&](std::uint32_t k, std::uint32_t end) noexcept {
    for (; k < end; ++k) solve<kBias, true, kFriction, kTotals>(rows_.all[k], bodies, rule, order_);
  });
  for (std::uint32_t k = singles_.first_fixed; k < singles_.all.size(); ++k)
    solve<kBias, true, kFriction, kTotals>(singles_.all[k], bodies, rule, order_);
  add_change(bodies);
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::solve_biased(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction) noexcept {
  friction ? sweep<true, true, false>(bodies, rule) : sweep<true, false, false>(bodies, rule);
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::relax(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction,
                                     bool last) noexcept {
  if (!last) return sweep<false, false, false>(bodies, rule);
  friction ? sweep<false, true, true>(bodies, rule) : sweep<false, false, true>(bodies, rule);
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::add_to_totals() noexcept {
  for_each_row([](auto& row) {
    for (std::uint32_t i = 0; i < row.points; ++i) {
      row.total_normal_impulse[i] += row.normal_impulse[i];
      for (int d = 0; d < 2; ++d) row.total_tangent_impulse[d][i] += row.tangent_impulse[d][i];
    }
  });
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::scale_impulses(T factor) noexcept {
  for (Twist<T>& given : accumulated_delta_v_) given *= factor;
  for_each_row([factor](auto& row) {
    const auto f = std::remove_reference_t<decltype(row.friction)>(factor);
    for (std::uint32_t i = 0; i < row.points; ++i) {
      row.normal_impulse[i] *= f;
      for (int d = 0; d < 2; ++d) row.tangent_impulse[d][i] *= f;
    }
  });
}

template <class T, int kWidth>
template <bool kTotals>
void ContactSolver<T, kWidth>::store_rows(std::span<Contact> contacts, double share) const noexcept {
  const auto blend = [share](double& kept, T now) noexcept { store_impulse(kept, static_cast<double>(now), share); };
  for_each_row([&](const auto& row) {
    for (std::uint32_t used = 0; used < row.used; ++used) {
      const int lane = static_cast<int>(used);
      const Vec3<T> t1 = lane_of(row.t1, lane), t2 = lane_of(row.t2, lane);
      Contact& contact = contacts[row.contact[used]];
      for (std::uint32_t i = 0; i < contact.count; ++i) {
        ContactPoint& point = contact.points[i];
        blend(point.normal_impulse, lane_of(row.normal_impulse[i], lane));
        for (int d = 0; d < 2; ++d) blend(point.tangent_impulse[d], lane_of(row.tangent_impulse[d][i], lane));
        if constexpr (kTotals) {
          point.total_normal_impulse = static_cast<double>(lane_of(row.total_normal_impulse[i], lane));
          point.total_friction = number_cast<double>(lane_of(row.total_tangent_impulse[0][i], lane) * t1 +
                                                     lane_of(row.total_tangent_impulse[1][i], lane) * t2);
        }
      }
    }
  });
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::store(std::span<Contact> contacts, double share) const noexcept {
  store_rows<true>(contacts, share);
}

template <class T, int kWidth>
void ContactSolver<T, kWidth>::keep_impulses(std::span<Contact> contacts) const noexcept {
  store_rows<false>(contacts, 1.0);
}

template class ContactSolver<double, kLanes<Register<double>>>;
template class ContactSolver<float, kLanes<Register<float>>>;
template class ContactSolver<double, 1>;
template class ContactSolver<float, 1>;

}  // namespace tactus::physics
