#include "rt/haptics/coupling/border_correction.h"

namespace tactus::haptics {

MotionCorrection correction_between(BodyId member, const physics::BodyMotion& predicted,
                                    const physics::BodyMotion& global) noexcept {
  return {.id = member,
          .displacement_m = global.pose.position - predicted.pose.position,
          .rotation = normalized(global.pose.rotation * conjugate(predicted.pose.rotation)),
          .velocity = global.velocity - predicted.velocity};
}

physics::BodyMotion corrected(const physics::BodyMotion& motion, const MotionCorrection& correction) noexcept {
  return {{motion.pose.position + correction.displacement_m, normalized(correction.rotation * motion.pose.rotation)},
          motion.velocity + correction.velocity};
}

}  // namespace tactus::haptics
