// `tactus view`: serves the page's files over HTTP and the run over a WebSocket, on loopback alone.
//
// Files are public; the WebSocket is for admitted pages (admission.h), at most kMaxPages. The run is read about 60
// times a second, by one thread that also serves; each page has a stream of its own (page_stream.h). What a page asks
// of the run goes over the run's control socket. The server has no right of the run's: it may end or hang at any time.
// Thread: one. Bound: kMaxPages pages, 64 HTTP connections of 8 KiB of header and 5 s; the files are in memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "rt/base/result.h"
#include "tools/publication/watcher.h"

namespace tactus::view {

inline constexpr std::size_t kMaxPages = 4;

// The page's files by path, as "/index.html". Error: the folder has none.
Result<std::map<std::string, std::string>> load_files(const std::filesystem::path& folder);

struct ViewSettings {
  std::uint16_t port{0};         // 0: any that is free
  bool allow_force{false};       // pages may arm, re-arm and reset a real device
  int connection{-1};            // that the run is watched over; stays the caller's
  std::filesystem::path socket;  // the run's control socket
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
  // Listens. Error: the port is in use, or the run's scene cannot be read.
  static Result<std::unique_ptr<ViewServer>> open(ViewSettings settings, std::unique_ptr<publication::Watcher> watcher);
  virtual ~ViewServer() = default;

  virtual std::string address() const = 0;  // with the token in its fragment
  // Serves until `stop`, or until the run is over and its pages know.
  virtual ViewReport serve(const std::atomic<bool>& stop) = 0;
};

}  // namespace tactus::view
