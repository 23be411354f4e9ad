// The descriptors that the kernel's FunctionFS wants written to its endpoint 0: interface and endpoints for full and
// for high speed, Microsoft OS 1.0 descriptors (compatible ID WINUSB, device interface GUID), and the interface's name.
//
// Thread: [setup]. Source: linux/usb/functionfs.h; USB 2.0 chapter 9.6; Microsoft OS 1.0 descriptors, extended compat
// ID and extended properties.
#pragma once

#include <string>

namespace tactus::firmware {

// Bytes as they go to ep0, first this, then the strings.
std::string functionfs_descriptors();
std::string functionfs_strings();

}  // namespace tactus::firmware
