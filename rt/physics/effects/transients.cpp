#include "rt/physics/effects/transients.h"

#include <algorithm>
#include <numbers>

#include "rt/base/list_bytes.h"
#include "rt/physics/effects/contact_speed.h"

namespace tactus::physics {
namespace {

double amplitude_squared(double sine, double cosine) noexcept { return sine * sine + cosine * cosine; }

}  // namespace

void Transients::register_stages(StageTable& table) noexcept {
  table.add<&Transients::look_ahead>(Phase::kPrepare, *this);
  table.add<&Transients::ring>(Phase::kFinish, *this);
}

void Transients::save(ByteWriter& out) const noexcept {
  write_list(out, state_.ringing);
  write_list(out, state_.touched);
}

bool Transients::restore(ByteReader& in) noexcept {
  const bool good = read_list(in, state_.ringing) && read_list(in, state_.touched);
  if (!good) state_ = {};
  return good;
}

// Lists the proxy's contacts with ringing surfaces and their speed of approach, before any impulse of the step.
void Transients::look_ahead(StageContext& c) noexcept {
  touches_.clear();
  for (std::uint32_t k = 0; k < c.contacts.size(); ++k) {
    const Contact& contact = c.contacts[k];
    const BodyId a = c.bodies[contact.slot_a].id;
    const BodyId b = contact.b_fixed ? c.fixed_bodies[contact.slot_b].id : c.bodies[contact.slot_b].id;
    if (a != setup_.proxy && b != setup_.proxy) continue;
    const BodyId other = a == setup_.proxy ? b : a;
    if (other >= setup_.by_id.size() || setup_.by_id[other].strength_Ns_per_m == 0.0) continue;
    double speed = 0.0;
    for (std::uint32_t i = 0; i < contact.count; ++i) speed = std::max(speed, -separating_speed(c, contact, i));
    (void)touches_.try_push({.contact = k, .other = other, .speed = speed});
  }
}

void Transients::start(const Oscillation& oscillation) noexcept {
  if (state_.ringing.try_push(oscillation)) return;
  const auto strength = [](const Oscillation& o) noexcept { return amplitude_squared(o.sine_N, o.cosine_N); };
  Oscillation& weakest =
      *std::min_element(state_.ringing.begin(), state_.ringing.end(),
                        [&](const Oscillation& p, const Oscillation& q) { return strength(p) < strength(q); });
  if (strength(weakest) < strength(oscillation)) weakest = oscillation;
}

void Transients::ring(StageContext& c) noexcept {
  FixedVector<BodyId, kMaxTouched> touched{};
  for (const Touch& touch : touches_) {
    const Contact& contact = c.contacts[touch.contact];
    const auto points = std::span(contact.points).first(contact.count);
    if (std::none_of(points.begin(), points.end(), [](const auto& p) { return p.total_normal_impulse > 0.0; }))
      continue;
    (void)touched.try_push(touch.other);
    const auto before = state_.touched.span();
    if (touch.speed < kMinSpeed || std::find(before.begin(), before.end(), touch.other) != before.end()) continue;
    const Ringing& surface = setup_.by_id[touch.other];
    const bool proxy_is_a = c.bodies[contact.slot_a].id == setup_.proxy;
    start({.direction = proxy_is_a ? -contact.normal : contact.normal,
           .sine_N = 0.0,
           .cosine_N = surface.strength_Ns_per_m * touch.speed,
           .frequency_Hz = surface.frequency_Hz,
           .decay_s = surface.decay_s});
  }
  state_.touched = touched;

  std::uint32_t kept = 0;
  for (Oscillation& o : state_.ringing) {
    const auto [s, cosine] = sin_cos(2.0 * std::numbers::pi * o.frequency_Hz * c.settings.dt);
    const double x = 0.5 * c.settings.dt / o.decay_s, fade = (1.0 - x) / (1.0 + x);
    const double sine_N = fade * (cosine * o.sine_N + s * o.cosine_N);
    o.cosine_N = fade * (cosine * o.cosine_N - s * o.sine_N);
    o.sine_N = sine_N;
    c.report.hand_wrench.force += o.sine_N * o.direction;
    if (amplitude_squared(o.sine_N, o.cosine_N) > kFaded_N * kFaded_N) state_.ringing[kept++] = o;
  }
  state_.ringing.count = kept;
}

}  // namespace tactus::physics
