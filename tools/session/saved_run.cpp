// The state of a run in virtual time: saves and restores all of its parts.
#include "tools/session/virtual_run.h"

namespace tactus::session {

// Of one hand.
struct SavedHand {
  std::vector<std::byte> loop;
  Driver::State driver;
  loop::Governor governor;
  std::optional<hal::SimulatedDevice> device;   // none with a device of the caller's own
  std::unique_ptr<haptics::Exchange> exchange;  // null with the direct coupling
  loop::RunStats stats;
  Session::Progress progress;
};

namespace {

SavedHand save_hand(const Session& session) {
  std::vector<std::byte> bytes(session.loop->save_size_bound());
  ByteWriter out(bytes);
  session.loop->save(out);
  TACTUS_CHECK(out.ok(), out.size(), bytes.size());
  bytes.resize(out.size());
  SavedHand saved{.loop = std::move(bytes),
                  .driver = session.driver->state(),
                  .governor = *session.governor,
                  .device = {},
                  .exchange = {},
                  .stats = session.stats,
                  .progress = session.progress()};
  if (const hal::SimulatedDevice* device = session.simulated()) saved.device = *device;
  if (session.exchange == nullptr) return saved;
  saved.exchange = std::make_unique<haptics::Exchange>();
  saved.exchange->snapshots.copy_from(session.exchange->snapshots);
  saved.exchange->reports.copy_from(session.exchange->reports);
  return saved;
}

void restore_hand(const SavedHand& saved, Session& session) {
  ByteReader in(saved.loop);
  const bool whole = session.loop->restore(in);
  TACTUS_CHECK(whole, saved.loop.size(), in.remaining());
  session.driver->set_state(saved.driver);
  *session.governor = saved.governor;
  if (saved.device) *session.device->as<hal::SimulatedDevice>() = *saved.device;
  session.stats = saved.stats;
  session.set_progress(saved.progress);
  if (session.exchange == nullptr) return;
  session.exchange->snapshots.copy_from(saved.exchange->snapshots);
  session.exchange->reports.copy_from(saved.exchange->reports);
}

}  // namespace

struct VirtualRun::Saved {
  std::vector<SavedHand> hands;
  std::uint32_t resets_of_all{0};                         // 0 with one hand
  std::shared_ptr<const sim::GlobalWorld::Saved> global;  // null with the direct coupling
  std::uint64_t next_report{0};
  VirtualWorld::Clock clock;
  std::uint64_t tick{0};
};

std::shared_ptr<const VirtualRun::Saved> VirtualRun::save() const {
  auto saved = std::make_shared<Saved>();
  const Session& first = *hands_.front();
  for (const Session* hand : hands_) saved->hands.push_back(save_hand(*hand));
  if (first.resets_of_all != nullptr) saved->resets_of_all = first.resets_of_all->load(std::memory_order_relaxed);
  saved->tick = tick_;
  if (!world_) return saved;
  saved->global = first.global->save();
  saved->next_report = world_->next_report();
  saved->clock = world_->clock();
  return saved;
}

void VirtualRun::restore(const Saved& saved) {
  const Session& first = *hands_.front();
  for (std::size_t hand = 0; hand < hands_.size(); ++hand) restore_hand(saved.hands[hand], *hands_[hand]);
  if (first.resets_of_all != nullptr) first.resets_of_all->store(saved.resets_of_all, std::memory_order_relaxed);
  tick_ = saved.tick;
  if (!world_) return;
  first.global->restore(*saved.global);
  world_->continue_at(saved.clock, saved.next_report);
}

}  // namespace tactus::session
