#include "tools/export/body_frames.h"

#include <cstring>

#include "sim/model/given_pose.h"

namespace tactus::exporting {

BodyFrames::BodyFrames(std::unique_ptr<loop::HapticLoop> loop, const sim::Scene& scene, double rate_Hz, double period_s)
    : player_(std::move(loop)), scene_(scene), rate_Hz_(rate_Hz), period_s_(period_s) {}

Status BodyFrames::take(const loop::TapeRecord& record) {
  if (record.kind == loop::kSnapshotRecord) return player_.take_snapshot(record);
  bool same = true;
  return player_.take_keyframe(record, same);
}

void BodyFrames::play(const loop::TickRecord& taped) {
  loop::TickOutput out;
  played_ = player_.play(taped, out);
  if (!played_)
    ++unreplayable_;
  else if (std::memcmp(&out, &taped.out, sizeof out) != 0)
    ++different_;
}

bool BodyFrames::due(const loop::TickRecord& taped) {
  constexpr double kRounding = 1e-9;  // so that 1000 Hz of 1 ms is every tick
  const auto interval =
      static_cast<std::uint64_t>(static_cast<double>(taped.out.tick) * period_s_ * rate_Hz_ + kRounding);
  if (!played_ || interval < next_frame_) return false;
  next_frame_ = interval + 1;
  return true;
}

ExportedFrame BodyFrames::frame(const loop::TickRecord& taped) {
  const physics::World& world = player_.loop().sub_world().world();
  states_.clear();
  for (const physics::Body& body : world.bodies())
    states_.push_back({.id = body.id,
                       .role = body.id == scene_.proxy ? MemberRole::kProxy : MemberRole::kMember,
                       .pose = body.motion.pose,
                       .given = sim::given_pose(scene_, body.id, body.motion.pose)});
  for (const physics::BorderContact& contact : world.border_contacts())
    if (const auto slot = world.slot_of(contact.member))
      if (ExportedBody& state = states_[number_of(*slot)]; state.role == MemberRole::kMember)
        state.role = MemberRole::kBorder;
  return {taped.out.tick, time_of(taped.out.tick, period_s_), states_};
}

}  // namespace tactus::exporting
