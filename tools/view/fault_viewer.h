// Serves the tape of a run's fault, the flight recorder's last seconds, at an address of its own, beside the run's
// page.
//
// Thread: all calls from one, and none waits; a thread of its own opens the tapes and serves them. Bound: one tape at a
// time: the next fault's takes its place.
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>

namespace tactus::view {

class FaultViewer {
 public:
  // `files`: of the page.
  explicit FaultViewer(std::map<std::string, std::string> files);
  ~FaultViewer();
  FaultViewer(const FaultViewer&) = delete;
  FaultViewer& operator=(const FaultViewer&) = delete;

  void open(const std::string& tape);
  // Of the tape that was opened last, with a token; empty: not yet, or error() says why not.
  std::string address() const;
  std::string error() const;

 private:
  void run();
  void serve(const std::string& tape, unsigned number);
  void tell(unsigned number, std::string address, std::string error);

  std::map<std::string, std::string> files_;
  mutable std::mutex mutex_;
  std::condition_variable asked_;
  // Under the mutex.
  bool ends_{false};
  unsigned number_{0}, taken_{0};  // of the tape requested last; of the one that is open or was
  std::string tape_, address_, error_;

  std::atomic<bool> stop_{false};  // serving: another tape is requested, or the end
  std::thread thread_;
};

}  // namespace tactus::view
