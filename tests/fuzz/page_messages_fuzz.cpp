// Any bytes are what a page sends and what its request claims to be: a message is understood or refused in one line,
// and nothing but this machine, its own origin and the token is admitted.
#include <cstdlib>
#include <string>
#include <string_view>

#include "tools/view/admission.h"
#include "tools/view/page_messages.h"

using namespace tactus::view;

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void check_message(std::string_view text) {
  const auto message = parse_message(text);
  if (!message.ok()) return require(message.message().find('\n') == std::string::npos);
  require(text.size() <= kLongestMessage);
  const auto& said = message.value();
  require((said.acknowledged != 0) + !said.ask.empty() + said.hand.has_value() == 1);
}

}  // namespace

// The bytes are a message; cut at their line ends, they are Host, Origin and protocols.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  check_message(text);
  const std::size_t one = text.find('\n'), two = one == text.npos ? one : text.find('\n', one + 1);
  if (two == text.npos) return 0;
  const std::string_view host = text.substr(0, one), origin = text.substr(one + 1, two - one - 1),
                         protocols = text.substr(two + 1);
  const std::string token = "0123456789abcdef0123456789abcdef";
  if (refuse(host, origin, protocols, token) != Refusal::kNone) return 0;
  require(host.starts_with("localhost") || host.starts_with("127.0.0.1") || host.starts_with("[::1]"));
  require(origin == "http://" + std::string(host) && protocols == "tactus, " + token);
  return 0;
}
