// The board as a USB device towards the kernel: a gadget in configfs with one FunctionFS function, identity, serial
// number and Microsoft OS descriptors; put together, bound to the device controller, and taken apart again.
//
// Needs root (configfs, mount). Thread: [setup]. Bound: a few system calls each; a gadget of the same name that an
// earlier run left behind is taken apart first. Every error: one line that says what to do; empty: none.
// Source: Linux Documentation/usb/gadget_configfs.rst, ABI/testing/configfs-usb-gadget.
#pragma once

#include <cstdint>
#include <string>

#include "firmware/usb_interface.h"

namespace tactus::firmware {

struct GadgetOptions {
  std::string serial;                    // 1 to 126 printable ASCII characters, one device's own
  std::string udc;                       // the device controller, a name in /sys/class/udc; empty: the only one
  std::string name{"tactus"};            // of the gadget and its function
  std::string mount{"/run/tactus/usb"};  // where FunctionFS goes; made if it is not there
  std::string manufacturer{"tactus"}, product{"tactus force-feedback device"};
  std::uint16_t vendor{kUsbVendor}, product_id{kUsbProduct};
};

class UsbGadget {
 public:
  UsbGadget() = default;
  ~UsbGadget() { remove(); }
  UsbGadget(const UsbGadget&) = delete;
  UsbGadget& operator=(const UsbGadget&) = delete;

  // Gadget and mounted FunctionFS; not bound: the function's descriptors have to be written first.
  std::string create(const GadgetOptions& options);
  // The pull-up on and off: what the host sees as plugging and unplugging.
  std::string bind();
  void unbind() noexcept;
  // All of it. Whoever holds files of FunctionFS closes them first.
  void remove() noexcept;

  const std::string& udc() const noexcept { return udc_; }

 private:
  std::string choose_udc(const std::string& wanted);
  std::string fill(const GadgetOptions& options);

  std::string gadget_, mount_, name_, udc_;  // the first two are paths; empty: nothing was made
};

}  // namespace tactus::firmware
