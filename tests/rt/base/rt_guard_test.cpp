#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"

#include <sys/mman.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <thread>
#include <vector>

using tactus::test::RtGuard;

namespace {

// What the optimiser may not see through.
template <class T>
void keep(T& value) {
  asm volatile("" : "+m"(value)::"memory");
}

struct Counts {
  std::uint64_t allocations, frees, locks;
};

// Assertions allocate: read first, then check.
template <class Work>
Counts counts_of(Work&& work) {
  const RtGuard guard;
  work();
  return {guard.allocations(), guard.frees(), guard.locks()};
}

}  // namespace

TEST_CASE("the guard counts allocations and frees of every kind", "[base]") {
  TACTUS_NEEDS(RtGuard::available(), "counting allocations needs a build without a sanitizer");
  const Counts with_malloc = counts_of([] {
    void* block = std::malloc(10);
    keep(block);
    std::free(block);
  });
  CHECK(with_malloc.allocations == 1);
  CHECK(with_malloc.frees == 1);

  const Counts with_new = counts_of([] {
    auto number = std::make_unique<int>(3);
    keep(number);
  });
  CHECK(with_new.allocations == 1);
  CHECK(with_new.frees == 1);

  const Counts aligned = counts_of([] {
    struct alignas(64) Line {
      char bytes[64];
    };
    auto* line = new Line;
    keep(line);
    delete line;
    void* block = std::aligned_alloc(64, 128);
    keep(block);
    std::free(block);
    if (posix_memalign(&block, 64, 128) == 0) std::free(block);
  });
  CHECK(aligned.allocations == 3);
  CHECK(aligned.frees == 3);

  const Counts changed = counts_of([] {
    void* block = std::calloc(4, 4);
    keep(block);
    block = std::realloc(block, 4000);
    keep(block);
    std::free(block);
    std::free(nullptr);
  });
  CHECK(changed.allocations == 2);
  CHECK(changed.frees == 2);
}

TEST_CASE("the guard counts the allocation of a vector that grows, and none of one with capacity", "[base]") {
  TACTUS_NEEDS(RtGuard::available(), "counting allocations needs a build without a sanitizer");
  std::vector<int> numbers;
  numbers.reserve(4);
  const Counts within = counts_of([&] {
    for (int i = 0; i < 4; ++i) numbers.push_back(i);
  });
  CHECK(within.allocations == 0);
  CHECK(within.frees == 0);
  const Counts beyond = counts_of([&] { numbers.push_back(4); });
  CHECK(beyond.allocations == 1);
  CHECK(beyond.frees == 1);
}

TEST_CASE("the guard counts locks taken and waits on conditions", "[base]") {
  TACTUS_NEEDS(RtGuard::available(), "counting allocations needs a build without a sanitizer");
  std::mutex mutex;
  std::shared_mutex shared;
  std::condition_variable condition;
  CHECK(counts_of([&] { const std::lock_guard lock(mutex); }).locks == 1);
  CHECK(counts_of([&] {
          if (mutex.try_lock()) mutex.unlock();
        }).locks == 1);
  CHECK(counts_of([&] { const std::shared_lock lock(shared); }).locks == 1);
  CHECK(counts_of([&] { const std::unique_lock lock(shared); }).locks == 1);
  CHECK(counts_of([&] {
          std::unique_lock lock(mutex);
          condition.wait_for(lock, std::chrono::nanoseconds(1));
        }).locks == 2);
}

TEST_CASE("the guard counts its own thread only", "[base][threads]") {
  TACTUS_NEEDS(RtGuard::available(), "counting allocations needs a build without a sanitizer");
  std::unique_ptr<int> made_elsewhere;
  std::thread other;
  std::mutex mutex;
  bool begin = false, done = false;
  std::condition_variable changed;
  other = std::thread([&] {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return begin; });
    made_elsewhere = std::make_unique<int>(1);
    done = true;
    changed.notify_all();
  });
  const Counts counts = counts_of([&] {
    std::unique_lock lock(mutex);
    begin = true;
    changed.notify_all();
    changed.wait(lock, [&] { return done; });
  });
  other.join();
  CHECK(counts.allocations == 0);
  CHECK(made_elsewhere != nullptr);
}

TEST_CASE("the guard counts the page faults of a mapping touched for the first time, and none the second", "[base]") {
  constexpr std::size_t kPages = 16;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* mapping = mmap(nullptr, kPages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  REQUIRE(mapping != MAP_FAILED);
  madvise(mapping, kPages * page, MADV_NOHUGEPAGE);
  auto* bytes = static_cast<volatile char*>(mapping);
  const auto touch = [&] {
    const RtGuard guard;
    for (std::size_t i = 0; i < kPages; ++i) bytes[i * page] = 1;
    return guard.minor_faults() + guard.major_faults();
  };
  (void)RtGuard().minor_faults();  // its own pages
  const auto first = touch(), second = touch();
  munmap(mapping, kPages * page);
  // At most one a page: the kernel may map several at a fault.
  CHECK(first >= 1);
  if (RtGuard::available()) CHECK(second == 0);
}

TEST_CASE("work on the stack counts nothing", "[base]") {
  const Counts counts = counts_of([] {
    int numbers[100] = {};
    for (int i = 0; i < 100; ++i) numbers[i] = i;
    keep(numbers);
  });
  CHECK(counts.allocations == 0);
  CHECK(counts.frees == 0);
  CHECK(counts.locks == 0);
}
