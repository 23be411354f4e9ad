// Creates, binds and removes the board's USB gadget in configfs, with one FunctionFS function, identity, serial number
// and Microsoft OS descriptors.
//
// Needs root (configfs, mount). Thread: [setup]. Bound: a few system calls each; a gadget of the same name that an
// earlier run left behind is removed first. Every error: one line that says what to do; empty: none.
// Source: Linux Documentation/usb/gadget_configfs.rst, ABI/testing/configfs-usb-gadget.
#pragma once

#include <cstdint>
#include <string>

#include "firmware/usb_interface.h"

namespace tactus::firmware {

struct GadgetOptions {
  std::string serial;                    // 1 to 126 printable ASCII characters, unique per device
  std::string udc;                       // the device controller, a name in /sys/class/udc; empty: the only one
  std::string name{"tactus"};            // of the gadget and its function
  std::string mount{"/run/tactus/usb"};  // mount point of FunctionFS; created if missing
  std::string manufacturer{"tactus"}, product{"tactus force-feedback device"};
  std::uint16_t vendor{kUsbVendor}, product_id{kUsbProduct};
};

class UsbGadget {
 public:
  UsbGadget() = default;
  ~UsbGadget() { remove(); }
  UsbGadget(const UsbGadget&) = delete;
  UsbGadget& operator=(const UsbGadget&) = delete;

  // Creates the gadget and mounts FunctionFS. Does not bind: the function's descriptors must be written first.
  std::string create(const GadgetOptions& options);
  // Switch the pull-up on and off: for the host this is plugging and unplugging.
  std::string bind();
  void unbind() noexcept;
  // Removes everything. All files of FunctionFS must be closed first.
  void remove() noexcept;

  const std::string& udc() const noexcept { return udc_; }

 private:
  std::string choose_udc(const std::string& wanted);
  std::string fill(const GadgetOptions& options);

  std::string gadget_, mount_, name_, udc_;  // gadget_ and mount_ are paths; empty: not created
};

}  // namespace tactus::firmware
