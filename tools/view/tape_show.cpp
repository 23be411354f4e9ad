#include "tools/view/tape_show.h"

#include <algorithm>

#include "tools/publication/packed.h"

namespace tactus::view {
namespace {

using publication::ContactForce;
using publication::Frame;
using publication::TickEntry;

constexpr std::uint32_t kNoPlace = 0xffffffffu;

}  // namespace

Result<std::unique_ptr<TapeShow>> TapeShow::open(const std::string& path) {
  auto tape = session::open_tape(path);
  if (!tape.ok()) return tape.status();
  auto session = session::session_of(tape.value());
  if (!session.ok()) return session.status();
  std::unique_ptr<TapeShow> show(new TapeShow(std::move(tape).value(), std::move(session).value()));
  auto index = index_of(show->tape_, &show->counts_);
  if (!index.ok()) return index.status();
  show->index_ = std::move(index).value();
  show->history_ = std::make_unique<WorldHistory>(show->tape_.path, show->bodies_, show->index_.first_tick);
  std::vector<TickEntry> ignored;
  if (!show->seek(show->index_.keyframes.front().tick, ignored))
    return Status::error(path + ": cannot be read twice; accepted: a file");
  return show;
}

TapeShow::TapeShow(session::OpenTape tape, std::unique_ptr<session::Session> session)
    : tape_(std::move(tape)),
      session_(std::move(session)),
      counts_(*session_),
      player_(std::move(session_->loop)),
      place_of_(session_->scene.bodies.size(), kNoPlace) {
  for (const physics::Body& body : session_->scene.bodies)
    if (body.kind == physics::BodyKind::kDynamic) place_of_[body.id] = static_cast<std::uint32_t>(bodies_++);
}

const std::optional<session::RunVerdict>& TapeShow::verdict() {
  if (verdict_ || !history_->done()) return verdict_;
  const auto world = history_->statistics();
  if (world) counts_.take_world(*world);
  session::RunSummary summary = counts_.so_far();
  summary.has_global = summary.has_global && world.has_value();
  return verdict_ = session::judge(summary);
}

bool TapeShow::next_tick(bool play, TickEntry& entry) {
  loop::TapeRecord record;
  const auto lose = [&](const std::string&, std::uint64_t) { player_.lose_step(); };
  while (session::next_record(tape_, record, lose)) {
    bool same = true;
    if (record.kind == loop::kTapeGap) player_.lose_step();
    if (play && record.kind == loop::kKeyframeRecord && !player_.take_keyframe(record, same).ok()) player_.lose_step();
    if (play && record.kind == loop::kSnapshotRecord && !player_.take_snapshot(record).ok()) player_.lose_step();
    if (record.kind != loop::kTickRecord) continue;
    const auto taped = session::tick_of(record);
    if (!taped.ok()) continue;
    entry = {.sequence = 0, .tick = taped.value(), .times = {}};
    loop::TickOutput out;
    played_ = play && player_.play(entry.tick, out);
    adopted_ = entry.tick.adopts != 0;
    tick_ = entry.tick.out.tick;
    if (!index_.has_times || !session::next_record(tape_, record, lose)) return true;
    const auto times = session::times_of(record);
    if (record.kind == loop::kTimesRecord && times.ok())
      entry.times = times.value();
    else
      (void)tape_.reader->go_to(record.offset, record.index);
    return true;
  }
  return false;
}

bool TapeShow::seek(std::uint64_t tick, std::vector<TickEntry>& ticks) {
  tick = std::clamp(tick, index_.keyframes.front().tick, index_.last_tick);
  const std::uint64_t from = tick - std::min(tick, kTicksBefore);
  const auto& begin = index_.keyframes[index_.keyframe_before(from)];
  const std::uint64_t play_from = index_.keyframes[index_.keyframe_before(tick)].tick;
  player_.lose_step();
  if (!tape_.reader->go_to(begin.offset, begin.index)) return false;
  // The keyframe precedes its tick, so playing starts one tick earlier.
  for (bool play = begin.tick == play_from;;) {
    TickEntry entry;
    if (!next_tick(play, entry)) return false;
    const std::uint64_t reached = entry.tick.out.tick;
    if (reached >= from) ticks.push_back(entry);
    if (reached >= tick) return true;
    play = play || reached + 1 >= play_from;
  }
}

bool TapeShow::step(std::vector<TickEntry>& ticks) {
  TickEntry entry;
  if (!next_tick(true, entry)) return false;
  ticks.push_back(entry);
  return true;
}

void TapeShow::take_frame(Frame& frame) const {
  const haptics::SubWorld& sub_world = player_.loop().sub_world();
  frame.head = {.tick = tick_,
                .time_s = static_cast<double>(tick_ + 1) * period_s(),
                .bodies = static_cast<std::uint32_t>(bodies_),
                .resets = sub_world.epoch()};
  const std::uint64_t next_cycle = player_.loop().next_cycle();
  frame.contacts.clear();
  if (!played_ || next_cycle == 0 || !history_->read(next_cycle - 1, frame)) {
    frame.positions.assign(bodies_, {});
    frame.rotations.assign(bodies_, {});
    frame.roles.assign(bodies_, publication::kIsUnknown);
  }
  if (!played_) return;
  add_members(frame);
  add_contacts(frame);
  frame.head.contacts = static_cast<std::uint32_t>(frame.contacts.size());
}

void TapeShow::add_members(Frame& frame) const {
  const haptics::SubWorld& sub_world = player_.loop().sub_world();
  const auto show = [&](BodyId id, const Posed& pose, unsigned role) {
    const std::uint32_t place = id < place_of_.size() ? place_of_[id] : kNoPlace;
    if (place == kNoPlace) return;
    frame.positions[place] = publication::position_of(pose.position);
    frame.rotations[place] = publication::rotation_of(pose.rotation);
    frame.roles[place] = static_cast<std::uint8_t>(role);
  };
  for (const physics::Body& body : sub_world.world().bodies()) show(body.id, body.motion.pose, publication::kIsMember);
  for (const physics::BorderContact& contact : sub_world.world().border_contacts())
    if (contact.member < place_of_.size() && place_of_[contact.member] != kNoPlace)
      frame.roles[place_of_[contact.member]] |= publication::kIsBorder;
  const BodyId proxy = session_->scene.proxy;
  const unsigned border = frame.roles[place_of_[proxy]] & publication::kIsBorder;
  show(proxy, sub_world.proxy().pose, publication::kIsMember | publication::kIsProxy | border);
}

void TapeShow::add_contacts(Frame& frame) const {
  const physics::World& world = player_.loop().sub_world().world();
  const double per_s = 1.0 / period_s();
  for (const physics::Contact& contact : world.contacts())
    for (std::uint32_t i = 0; contact.touching() && i < contact.count; ++i)
      frame.contacts.push_back(publication::force_at(contact, i, world, per_s));
  for (const physics::BorderContact& contact : world.border_contacts()) {
    const auto slot = world.slot_of(contact.member);
    if (!slot) continue;
    const Posed& pose = world.bodies()[number_of(*slot)].motion.pose;
    const publication::Position f =
        publication::position_of(per_s * (contact.step_normal_impulse * contact.normal + contact.step_tangent_impulse));
    frame.contacts.push_back(
        {publication::position_of(contact.point_on(pose)), f.x, f.y, f.z, contact.outside, contact.member});
  }
}

}  // namespace tactus::view
