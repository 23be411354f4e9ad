// What the watchers of a run see: its publication, the verdict so far by the rules of the summary, and the tape of its
// fault.
//
// Thread: construction, recorded, look, end: the one that attends the run; watchers: [any]; stepped: the global
// world's; the records come by the drain's; each tape has a thread that writes it. Bound: a verdict five times a
// second, and only while somebody watches; one tape at a time.
#pragma once

#include <future>
#include <memory>

#include "tools/publication/publication.h"
#include "tools/service/control_server.h"
#include "tools/session/running_summary.h"

namespace tactus::tools {

class ShownRun {
 public:
  // Call before session.record(). Null, with a message, if the machine has no shared memory for watchers.
  static std::shared_ptr<ShownRun> make(session::Session& session);

  // Of the run `self`.
  static void stepped(void* self, const sim::GlobalWorld& world) noexcept;
  // Of a run in virtual time; `pacing` outlives this.
  void paced_by(const service::Pacing& pacing) noexcept { pacing_ = &pacing; }
  void take_setup(const loop::SetupReport& setup) { running_.take_setup(setup); }
  // Prints what is new. If a fault latched since the last call, its tape is being written, and is reported when
  // complete.
  void look(const session::LiveStatus& live);
  // Publishes the run's summary as its final state.
  void end(const session::RunSummary& summary);

  void add_to(service::Watchable& watchable) noexcept;
  std::uint32_t watchers() const noexcept { return publication_->watchers().load(std::memory_order_relaxed); }

 private:
  ShownRun(session::Session& session, std::unique_ptr<publication::Publication> publication);
  static void taken(void* self, std::uint32_t kind, std::span<const std::byte> payload) noexcept;
  bool watched() const noexcept { return watchers() != 0; }
  void say(const session::RunSummary& summary, bool ended);
  void keep_fault(const session::LiveStatus& live);
  void take_written();

  session::Session& session_;
  std::unique_ptr<publication::Publication> publication_;
  const service::Pacing* pacing_{nullptr};  // null: real time
  loop::RecordTap published_;
  session::RunningSummary running_;
  std::string fault_tape_, fault_tape_error_;
  std::uint64_t faults_kept_{0}, faults_told_{0};
  std::future<Status> writing_;  // the tape of the fault faults_kept_; declared last: its thread uses the other members
};

}  // namespace tactus::tools
