// Effect transients: an impact of the proxy adds a decaying vibration to the force on the hand.
//
// A coupling is too soft to transmit the first milliseconds of an impact, from which a person distinguishes wood and
// steel. When the proxy makes contact with a surface that has this effect, a decaying oscillation along the contact's
// normal is added to the force on the hand,
//  F(t) = A exp(-t / decay) sin(2 pi f t),  A = strength x speed of the impact.
// It acts on no body: it goes into StepReport::hand_wrench and is added to the device's wrench before the passivity
// controller, which counts its energy and bounds it. The energy of one impact is that of a decaying sine of amplitude
// A. A contact starts an oscillation only if the proxy did not touch that surface in the step before. The exponential
// is computed as (1 - x/2) / (1 + x/2), x = dt / decay.
// Units: SI. Thread: construction [setup]; the rest [rt], the owner of the World. Bound: contacts of the proxy,
// kMaxRinging oscillations (beyond: the weakest is dropped). Source: Okamura, Cutkosky, Dennerlein 2001, reality-based
// models for vibration feedback; Kuchenbecker, Fiene, Niemeyer 2006, event-based haptics.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

// The vibration of a surface after an impact.
struct Ringing {
  double strength_Ns_per_m{};  // N per m/s of the impact
  double frequency_Hz{};
  double decay_s{};
};

class Transients : public Stateless {  // nothing to export: only the hand receives it
 public:
  static constexpr std::uint32_t kMaxRinging = 8, kMaxTouched = 16;
  static constexpr double kMinSpeed = 0.005;  // m/s: below it, an intermittent contact would keep ringing
  static constexpr double kFaded_N = 1e-4;

  struct Setup {
    BodyId proxy{kNoBody};
    std::span<const Ringing> by_id{};  // bodies beyond the end, or of strength 0, do not ring. Must outlive the world
    bool used() const noexcept { return proxy != kNoBody && !by_id.empty(); }
  };
  Transients(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void register_stages(StageTable& table) noexcept;

  void reset() noexcept { state_ = {}; }
  void save(ByteWriter& out) const noexcept;
  bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept { return sizeof(state_); }

 private:
  struct Oscillation {
    Vec3d direction;              // unit, away from the surface
    double sine_N{}, cosine_N{};  // A sin and A cos of the phase
    double frequency_Hz{}, decay_s{};
  };
  struct State {
    FixedVector<Oscillation, kMaxRinging> ringing{};
    FixedVector<BodyId, kMaxTouched> touched{};  // by the proxy, in the last step
  };
  struct Touch {
    std::uint32_t contact{0};
    BodyId other{kNoBody};
    double speed{};  // m/s, of approach
  };

  void look_ahead(StageContext& c) noexcept;
  void ring(StageContext& c) noexcept;
  void start(const Oscillation& oscillation) noexcept;

  Setup setup_;
  State state_;
  FixedVector<Touch, kMaxTouched> touches_{};  // of this step
};

}  // namespace tactus::physics
