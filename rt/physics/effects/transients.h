// Effect transients: a blow rings in the hand.
//
// A coupling is too soft to carry the first milliseconds of an impact, by which a hand tells wood from steel. Where the
// proxy begins to touch a surface that rings, the hand feels beside the coupling's force a decaying oscillation along
// the contact's normal,
//   F(t) = strength x speed of the impact x exp(-t / decay) x sin(2 pi f t),
// that nothing else in the world knows of: it goes into StepReport::felt, is added to the wrench on the device before
// the passivity controller, and so is booked and bounded as all that the hand gets. Recorded: the energy of one blow is
// that of a sine of amplitude A that dies out. A surface rings anew when it was not touched in the step before. The
// exponential is taken as (1 - x/2) / (1 + x/2), x = dt / decay.
// Units: SI. Thread: construction [setup]; the rest [rt], the owner of the World. Bound: contacts of the proxy,
// kMostRinging oscillations (the weakest gives way). Source: Okamura, Cutkosky, Dennerlein 2001, reality-based models
// for vibration feedback; Kuchenbecker, Fiene, Niemeyer 2006, event-based haptics.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

// How a surface rings.
struct Ringing {
  double strength_Ns_per_m{};  // N per m/s of the impact
  double frequency_Hz{};
  double decay_s{};
};

class Transients : public Stateless {  // nothing for other worlds: only the hand's feels
 public:
  static constexpr std::uint32_t kMostRinging = 8, kMostTouched = 16;
  static constexpr double kLeastSpeed = 0.005;  // m/s: slower, a contact that comes and goes would buzz
  static constexpr double kFaded_N = 1e-4;

  struct Setup {
    BodyId proxy{kNoBody};
    std::span<const Ringing> by_id{};  // those beyond the end, or of strength 0, do not ring. Must outlive the world
    bool used() const noexcept { return proxy != kNoBody && !by_id.empty(); }
  };
  Transients(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void enter(StageTable& table) noexcept;

  void reset() noexcept { state_ = {}; }
  void save(ByteWriter& out) const noexcept { out.put(state_); }
  bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept { return sizeof(state_); }

 private:
  struct Oscillation {
    Vec3d direction;              // unit, away from the surface
    double sine_N{}, cosine_N{};  // A sin and A cos of the phase
    double frequency_Hz{}, decay_s{};
  };
  struct State {
    FixedVector<Oscillation, kMostRinging> ringing{};
    FixedVector<BodyId, kMostTouched> touched{};  // that the proxy touched in the last step
  };
  struct Touch {
    std::uint32_t contact{0};
    BodyId other{kNoBody};
    double speed{};  // m/s, at which they come together
  };

  void look_ahead(StageContext& c) noexcept;
  void ring(StageContext& c) noexcept;
  void start(const Oscillation& oscillation) noexcept;

  Setup setup_;
  State state_;
  FixedVector<Touch, kMostTouched> touches_{};  // of this step
};

}  // namespace tactus::physics
