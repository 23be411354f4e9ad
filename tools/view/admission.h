// Decides who may see a run through `tactus view`: no other page of the same browser, and no other user of the PC.
//
// A WebSocket needs all of: a Host that is this machine's loopback by name (a foreign one is DNS rebinding), an Origin
// equal to "http://" and that Host, and the token of this start, handed over as a sub-protocol. Pure. Thread: any.
#pragma once

#include <string>
#include <string_view>

namespace tactus::view {

// localhost, 127.0.0.1 or [::1], with any port: a tunnel has another one.
bool is_this_machine(std::string_view host) noexcept;

enum class Refusal { kNone, kHost, kOrigin, kToken };
std::string_view name_of(Refusal refusal) noexcept;

// `protocols`: the header Sec-WebSocket-Protocol, "tactus, TOKEN". The time does not depend on where a token differs.
Refusal refuse(std::string_view host, std::string_view origin, std::string_view protocols, std::string_view token);

// 128 random bits as 32 hexadecimal digits; empty if the system has none.
std::string make_token();

}  // namespace tactus::view
