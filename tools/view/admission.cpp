#include "tools/view/admission.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>

namespace tactus::view {
namespace {

bool same_token(std::string_view given, std::string_view token) noexcept {
  if (given.size() != token.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i)
    difference |= static_cast<unsigned>(static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(token[i]));
  return difference == 0;
}

}  // namespace

bool is_this_machine(std::string_view host) noexcept {
  for (const std::string_view name : {"localhost", "127.0.0.1", "[::1]"}) {
    if (!host.starts_with(name)) continue;
    const std::string_view rest = host.substr(name.size());
    if (rest.empty()) return true;
    const std::string_view port = rest.substr(1);
    return rest.front() == ':' && !port.empty() && port.size() <= 5 &&
           std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  }
  return false;
}

std::string_view name_of(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::kNone:
      break;
    case Refusal::kHost:
      return "host";
    case Refusal::kOrigin:
      return "origin";
    case Refusal::kToken:
      return "token";
  }
  return "";
}

Refusal refuse(std::string_view host, std::string_view origin, std::string_view protocols, std::string_view token) {
  constexpr std::string_view kScheme = "http://", kProtocol = "tactus, ";
  if (!is_this_machine(host)) return Refusal::kHost;
  if (!origin.starts_with(kScheme) || origin.substr(kScheme.size()) != host) return Refusal::kOrigin;
  const bool named = protocols.starts_with(kProtocol);
  if (!named || token.empty() || !same_token(protocols.substr(kProtocol.size()), token)) return Refusal::kToken;
  return Refusal::kNone;
}

std::string make_token() {
  std::array<unsigned char, 16> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size())) return {};
  std::string token;
  for (const unsigned char byte : bits) token += fmt::format("{:02x}", byte);
  return token;
}

}  // namespace tactus::view
