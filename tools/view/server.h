// `tactus view`: serves the page's files over HTTP and a run or tapes over WebSockets, on loopback alone.
//
// Files are public; the WebSockets /run, and /beside for the second of two tapes, are for admitted pages (admission.h),
// at most kMaxPages each. The source is looked at about 60 times a second, by one thread that also serves; each page
// has a stream of its own (page_stream.h). The server has no right of a run's: it may end or hang at any time. Thread:
// one. Bound: kMaxPages pages, 64 HTTP connections of 8 KiB of header and 5 s; the files are in memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "rt/base/result.h"
#include "tools/view/view_source.h"

namespace tactus::view {

inline constexpr std::size_t kMaxPages = 4;  // of each view

// The page's files by path, as "/index.html". Error: the folder has none.
Result<std::map<std::string, std::string>> load_files(const std::filesystem::path& folder);

struct ViewSettings {
  std::uint16_t port{0};    // 0: any that is free
  bool allow_force{false};  // pages may arm, re-arm and reset a real device
  std::map<std::string, std::string> files;
  std::string token;
};

struct ViewReport {
  std::uint64_t frames_sent{0}, frames_dropped{0}, bytes{0};
  std::size_t clients_most{0};
  std::map<std::string, std::uint64_t> refused;  // by reason
  bool run_ended{false};
};

class ViewServer {
 public:
  // Listens. Error: the port is in use.
  static Result<std::unique_ptr<ViewServer>> open(ViewSettings settings, std::unique_ptr<ViewSource> source);
  virtual ~ViewServer() = default;

  virtual std::string address() const = 0;  // with the token in its fragment
  // Serves until `stop`, or until the run is over and its pages are notified.
  virtual ViewReport serve(const std::atomic<bool>& stop) = 0;
};

}  // namespace tactus::view
