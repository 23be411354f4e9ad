#include "rt/thread/realtime_thread.h"

#include <limits.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace tactus::loop {
namespace {

std::size_t whole_pages(std::uint32_t KiB) noexcept {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const auto least = static_cast<std::size_t>(sysconf(_SC_THREAD_STACK_MIN));
  const std::size_t bytes = std::size_t{KiB} * 1024;
  return ((bytes > least ? bytes : least) + page - 1) / page * page;
}

}  // namespace

// A local of start(), valid until the thread has reported that it is ready.
struct RealtimeThread::Entry {
  RealtimeThread* self;
  sem_t ready;
};

void* RealtimeThread::enter(void* entry) noexcept {
  auto* start = static_cast<Entry*>(entry);
  RealtimeThread& self = *start->self;
  self.report_ = setup_realtime(self.setup_, self.awake_);
  sem_post(&start->ready);  // start() returns: `start` is invalid from here
  self.body_(self.context_);
  self.running_.store(false, std::memory_order_release);
  return nullptr;
}

Status RealtimeThread::start(std::uint32_t stack_KiB, const SetupRequest& setup, Body body, void* context) {
  if (started_) return Status::error("the thread runs already");
  setup_ = setup;
  body_ = body;
  context_ = context;
  Entry entry{this, {}};
  sem_init(&entry.ready, 0, 0);
  running_.store(true, std::memory_order_relaxed);  // before the thread exists: it may end at once

  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, whole_pages(stack_KiB));
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // inherited by the new thread
  pthread_t thread{};
  const int error = pthread_create(&thread, &attributes, &enter, &entry);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);

  if (error == 0) {
    while (sem_wait(&entry.ready) != 0 && errno == EINTR) {}
    thread_ = thread;
    started_ = true;
  } else {
    running_.store(false, std::memory_order_relaxed);
  }
  sem_destroy(&entry.ready);
  if (error == 0) return Status::good();
  return Status::error(std::string("no thread with a stack of ") + std::to_string(stack_KiB) +
                       " KiB: " + strerrordesc_np(error) + "; lower the stack size, or raise the limit of threads");
}

void RealtimeThread::join() noexcept {
  if (!started_) return;
  pthread_join(thread_, nullptr);
  started_ = false;
  awake_.release();
}

}  // namespace tactus::loop
