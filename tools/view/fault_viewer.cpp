#include "tools/view/fault_viewer.h"

#include "tools/caught.h"
#include "tools/view/admission.h"
#include "tools/view/server.h"
#include "tools/view/tape_source.h"

namespace tactus::view {

FaultViewer::FaultViewer(std::map<std::string, std::string> files)
    : files_(std::move(files)), thread_([this] { run(); }) {}

FaultViewer::~FaultViewer() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    stop_.store(true, std::memory_order_relaxed);
  }
  asked_.notify_one();
  thread_.join();
}

void FaultViewer::open(const std::string& tape) {
  {
    const std::lock_guard lock(mutex_);
    ++number_;
    tape_ = tape;
    address_.clear();
    error_.clear();
    stop_.store(true, std::memory_order_relaxed);
  }
  asked_.notify_one();
}

void FaultViewer::run() {
  for (;;) {
    std::string tape;
    unsigned number = 0;
    {
      std::unique_lock lock(mutex_);
      asked_.wait(lock, [this] { return ends_ || taken_ != number_; });
      if (ends_) return;
      tape = tape_;
      number = taken_ = number_;
      stop_.store(false, std::memory_order_relaxed);
    }
    if (const Status thrown = caught([&] { serve(tape, number); }); !thrown.ok()) tell(number, {}, thrown.message());
  }
}

void FaultViewer::serve(const std::string& tape, unsigned number) {
  auto source = TapeSource::open({tape});
  if (!source.ok()) return tell(number, {}, source.message());
  auto server = ViewServer::open({.port = 0, .allow_force = false, .files = files_, .token = make_token()},
                                 std::move(source).value());
  if (!server.ok()) return tell(number, {}, server.message());
  tell(number, server.value()->address(), {});
  (void)server.value()->serve(stop_);
}

// Ignores the result for a tape that is no longer requested.
void FaultViewer::tell(unsigned number, std::string address, std::string error) {
  const std::lock_guard lock(mutex_);
  if (number != number_) return;
  address_ = std::move(address);
  error_ = std::move(error);
}

std::string FaultViewer::address() const {
  const std::lock_guard lock(mutex_);
  return address_;
}

std::string FaultViewer::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

}  // namespace tactus::view
