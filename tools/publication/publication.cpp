#include "tools/publication/publication.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <tuple>

#include "rt/base/clock.h"
#include "rt/tape/tape.h"
#include "tools/publication/packed.h"
#include "tools/publication/shared_words.h"

namespace tactus::publication {
namespace {

constexpr std::uint32_t kNoPlace = 0xffffffffu;
constexpr std::uint64_t kPage = 4096;

Header header_for(std::size_t bodies, double period_s, std::size_t text_bytes) {
  Header header;
  header.tape_version = loop::kTapeVersion;
  header.period_s = period_s;
  header.bodies = static_cast<std::uint32_t>(bodies);
  header.text_offset = sizeof(Header);
  header.text_bytes = text_bytes;
  header.state_offset = rounded(header.text_offset + text_bytes);
  header.frames_offset = rounded(header.state_offset + sizeof(StateSlot), kPage);
  header.frame_stride = rounded(slot_bytes(bodies), kPage);
  header.ticks_offset = header.frames_offset + kFrameSlots * header.frame_stride;
  header.tick_stride = sizeof(TickEntry);
  header.tick_entries = kTickEntries;
  header.bytes = rounded(header.ticks_offset + kTickEntries * sizeof(TickEntry), kPage);
  return header;
}

std::string reason() { return strerrordesc_np(errno); }

}  // namespace

Result<std::unique_ptr<Publication>> Publication::create(const sim::Scene& scene, double period_s,
                                                         const std::string& text) {
  std::vector<std::uint32_t> places(scene.bodies.size(), kNoPlace);
  std::uint32_t moving = 0;
  for (const physics::Body& body : scene.bodies)
    if (body.kind == physics::BodyKind::kDynamic) places[body.id] = moving++;
  const Header header = header_for(moving, period_s, text.size());
  const auto fail = [](const char* what) {
    return Status::error(fmt::format("shared memory for watchers: {}: {}", what, reason()));
  };
  const int memory = memfd_create("tactus", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (memory < 0) return fail("cannot be made");
  const auto size = static_cast<std::size_t>(header.bytes);
  void* bytes = MAP_FAILED;
  if (ftruncate(memory, static_cast<off_t>(size)) == 0)
    bytes = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
  if (bytes == MAP_FAILED) {
    const Status status = fail("cannot be mapped");
    close(memory);
    return status;
  }
  std::unique_ptr<Publication> made(new Publication(memory, -1, static_cast<std::byte*>(bytes), header));
  made->proxy_ = scene.proxy;
  made->place_of_ = std::move(places);
  std::memcpy(made->bytes_, &header, sizeof header);
  std::memcpy(made->bytes_ + header.text_offset, text.data(), text.size());
  // From now on this mapping is the only one that can write.
  if (fcntl(memory, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0)
    return fail("cannot be sealed");
  made->read_only_ = open(fmt::format("/proc/self/fd/{}", memory).c_str(), O_RDONLY | O_CLOEXEC);
  if (made->read_only_ < 0) return fail("cannot be opened for reading");
  return made;
}

Publication::Publication(int memory, int read_only, std::byte* bytes, const Header& header)
    : memory_(memory), read_only_(read_only), bytes_(bytes), header_(header) {
  positions_.resize(header.bodies + 1);  // so that a frame's array ends with a whole word
  rotations_.resize(header.bodies);
  roles_.resize(rounded(header.bodies));
  in_component_.resize(header.bodies);
  contacts_.reserve(8 * std::size_t{kMaxContacts});
}

Publication::~Publication() {
  store_word(bytes_ + offsetof(Header, ended), 1);
  munmap(bytes_, static_cast<std::size_t>(header_.bytes));
  if (read_only_ >= 0) close(read_only_);
  close(memory_);
}

void Publication::taken(void* self, std::uint32_t kind, std::span<const std::byte> payload) noexcept {
  auto& publication = *static_cast<Publication*>(self);
  if (publication.watchers_.load(std::memory_order_relaxed) == 0) {
    publication.pending_.reset();
    return;
  }
  if (kind == loop::kTickRecord) publication.take_tick(payload);
  if (kind == loop::kTimesRecord) publication.take_times(payload);
  if (kind == loop::kBodiesRecord) publication.take_bodies(payload);
}

void Publication::take_tick(std::span<const std::byte> payload) noexcept {
  write_tick();
  if (payload.size() != sizeof(loop::TickRecord)) return;
  std::memcpy(&pending_.emplace().tick, payload.data(), payload.size());
}

void Publication::take_times(std::span<const std::byte> payload) noexcept {
  loop::TickTimesRecord times;
  if (!pending_ || payload.size() != sizeof times) return;
  std::memcpy(&times, payload.data(), sizeof times);
  if (times.tick == pending_->tick.out.tick) pending_->times = times;
  write_tick();
}

void Publication::write_tick() noexcept {
  if (!pending_) return;
  std::byte* const entry = bytes_ + header_.ticks_offset + (ticks_ % kTickEntries) * sizeof(TickEntry);
  store_word(entry, 2 * ticks_ + 1);
  store_words(entry + sizeof(std::uint64_t), reinterpret_cast<const std::byte*>(&*pending_) + sizeof(std::uint64_t),
              sizeof(TickEntry) - sizeof(std::uint64_t));
  store_word(entry, 2 * ticks_ + 2);
  store_word(bytes_ + offsetof(Header, ticks), ++ticks_);
  pending_.reset();
}

void Publication::take_bodies(std::span<const std::byte> payload) noexcept {
  loop::BodiesRecord record;
  if (payload.size() < sizeof record) return;
  std::memcpy(&record, payload.data(), sizeof record);
  if (payload.size() != sizeof record + record.bodies * sizeof(loop::BodyPose)) return;
  head_ = {.tick = record.tick,
           .time_s = static_cast<double>(record.tick) * header_.period_s,
           .bodies = header_.bodies,
           .resets = record.resets};
  contacts_.clear();
  std::fill(roles_.begin(), roles_.end(), std::uint8_t{0});
  for (std::uint32_t i = 0; i < record.bodies; ++i) {
    loop::BodyPose body;
    std::memcpy(&body, payload.data() + sizeof record + i * sizeof body, sizeof body);
    const std::uint32_t place = body.id < place_of_.size() ? place_of_[body.id] : kNoPlace;
    if (place == kNoPlace) continue;
    positions_[place] = {body.position[0], body.position[1], body.position[2]};
    rotations_[place] = {body.rotation[0], body.rotation[1], body.rotation[2], body.rotation[3]};
    roles_[place] = static_cast<std::uint8_t>(body.id == proxy_ ? kIsMember | kIsProxy : +kIsMember);
  }
  write_frame();
}

void Publication::say(std::string_view state) noexcept {
  StateSlot slot;
  if (state.size() > slot.text.size()) return;
  std::byte* const to = bytes_ + header_.state_offset;
  slot.bytes = state.size();
  std::memcpy(slot.text.data(), state.data(), state.size());
  store_word(to, 2 * states_ + 1);
  store_words(to + sizeof(std::uint64_t), reinterpret_cast<const std::byte*>(&slot) + sizeof(std::uint64_t),
              rounded(offsetof(StateSlot, text) + state.size()) - sizeof(std::uint64_t));
  store_word(to, 2 * states_ + 2);
  ++states_;
}

void Publication::stepped(void* self, const sim::GlobalWorld& world) noexcept {
  auto& publication = *static_cast<Publication*>(self);
  if (publication.watchers_.load(std::memory_order_relaxed) == 0) return;
  const std::int64_t now_ns = MonotonicClock::now_ns();
  if (now_ns < publication.next_frame_ns_) return;
  publication.next_frame_ns_ = now_ns + static_cast<std::int64_t>(1e9 / kMaxFrames_Hz);
  publication.pack(world);
}

// Of the hand whose scene this is.
std::uint32_t Publication::device_in(const sim::GlobalWorld& world) const noexcept {
  for (std::uint32_t device = 1; device < world.devices(); ++device)
    if (world.proxy_of(device) == proxy_) return device;
  return 0;
}

void Publication::pack(const sim::GlobalWorld& world) noexcept {
  const auto bodies = world.bodies();
  head_ = {.tick = world.statistics().steps,
           .time_s = world.time_s(),
           .bodies = static_cast<std::uint32_t>(std::min<std::size_t>(bodies.size(), header_.bodies)),
           .component = static_cast<std::uint32_t>(world.component(device_in(world)).size()),
           .resets = world.statistics().resets};
  for (std::uint32_t i = 0; i < head_.bodies; ++i) {
    positions_[i] = position_of(bodies[i].motion.pose.position);
    rotations_[i] = rotation_of(bodies[i].motion.pose.rotation);
  }
  pack_roles(world);
  pack_contacts(world);
  write_frame();
}

void Publication::pack_roles(const sim::GlobalWorld& world) noexcept {
  std::fill(roles_.begin(), roles_.begin() + head_.bodies, std::uint8_t{kIsAsleep});
  for (const physics::Body& awake : world.world().bodies()) roles_[place_of_[awake.id]] = 0;
  for (const sim::BodyIndex body : world.extraction(device_in(world)).members()) roles_[number_of(body)] |= kIsMember;
  if (proxy_ < place_of_.size() && place_of_[proxy_] < head_.bodies) roles_[place_of_[proxy_]] |= kIsProxy;
}

void Publication::pack_contacts(const sim::GlobalWorld& world) noexcept {
  contacts_.clear();
  std::fill(in_component_.begin(), in_component_.end(), std::uint8_t{0});
  for (const sim::BodyIndex body : world.component(device_in(world)))
    if (number_of(body) < in_component_.size()) in_component_[number_of(body)] = 1;
  const double impulse_s = world.impulse_s();
  const double per_s = impulse_s > 0 ? 1.0 / impulse_s : 0.0;
  for (const physics::Contact& contact : world.world().contacts()) add_contact(contact, world, per_s);
  const auto force = [](const ContactForce& c) { return c.x * c.x + c.y * c.y + c.z * c.z; };
  const std::size_t kept = std::min<std::size_t>(contacts_.size(), kMaxContacts);
  // Of more than fit those of the largest force; ties by the bodies, so that the order is total.
  if (contacts_.size() > kept)
    std::nth_element(contacts_.begin(), contacts_.begin() + static_cast<std::ptrdiff_t>(kept), contacts_.end(),
                     [&](const ContactForce& p, const ContactForce& q) {
                       return std::tuple(-force(p), p.a, p.b) < std::tuple(-force(q), q.a, q.b);
                     });
  head_.left_out += static_cast<std::uint32_t>(contacts_.size() - kept);
  contacts_.resize(kept);
}

void Publication::add_contact(const physics::Contact& contact, const sim::GlobalWorld& world, double per_s) noexcept {
  const BodyId a = world.world().bodies()[contact.slot_a].id, b = second_of(contact, world.world());
  const std::uint32_t place_a = place_of_[a], place_b = b < place_of_.size() ? place_of_[b] : kNoPlace;
  if (place_a >= in_component_.size()) return;
  const bool linked = in_component_[place_a] != 0 || (place_b < in_component_.size() && in_component_[place_b] != 0);
  if (!linked || !contact.touching()) return;
  if (place_b < in_component_.size() && ((roles_[place_a] ^ roles_[place_b]) & kIsMember) != 0) {
    std::uint8_t& member = (roles_[place_a] & kIsMember) != 0 ? roles_[place_a] : roles_[place_b];
    member |= kIsBorder;
  }
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    if (contacts_.size() == contacts_.capacity()) {
      ++head_.left_out;
      continue;
    }
    contacts_.push_back(force_at(contact, i, world.world(), per_s));
  }
}

void Publication::write_frame() noexcept {
  head_.contacts = static_cast<std::uint32_t>(contacts_.size());
  const std::uint64_t bodies = header_.bodies;
  std::byte* const slot = bytes_ + header_.frames_offset + (frames_ % kFrameSlots) * header_.frame_stride;
  store_word(slot, 2 * frames_ + 1);
  store_words(slot + sizeof(std::uint64_t), reinterpret_cast<const std::byte*>(&head_) + sizeof(std::uint64_t),
              sizeof head_ - sizeof(std::uint64_t));
  store_words(slot + positions_at(), positions_.data(), rounded(bodies * sizeof(Position)));
  store_words(slot + rotations_at(bodies), rotations_.data(), bodies * sizeof(Rotation));
  store_words(slot + roles_at(bodies), roles_.data(), rounded(bodies));
  store_words(slot + contacts_at(bodies), contacts_.data(), contacts_.size() * sizeof(ContactForce));
  store_word(slot, 2 * frames_ + 2);
  store_word(bytes_ + offsetof(Header, frames), ++frames_);
}

}  // namespace tactus::publication
