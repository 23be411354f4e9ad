// Notifies systemd of the service's state: ready, stopping, alive. Does nothing if systemd did not request it.
// Thread: normal. Source: sd_notify(3), the protocol over NOTIFY_SOCKET.
#pragma once

#include <string>

namespace tactus::service {

// Such as "READY=1", "STATUS=...", "WATCHDOG=1", "STOPPING=1". False: no receiver, or sending failed.
bool notify(const std::string& state);

// The watchdog's period that systemd set for this process [s]; 0: none.
double watchdog_period_s();

}  // namespace tactus::service
