// The descriptors to write to endpoint 0 of the kernel's FunctionFS: interface and endpoints for full and high speed,
// Microsoft OS 1.0 descriptors (compatible ID WINUSB, device interface GUID), and the interface's name.
//
// Thread: [setup]. Source: linux/usb/functionfs.h; USB 2.0 chapter 9.6; Microsoft OS 1.0 descriptors, extended compat
// ID and extended properties.
#pragma once

#include <string>

namespace tactus::firmware {

// Bytes to write to ep0: first the descriptors, then the strings.
std::string functionfs_descriptors();
std::string functionfs_strings();

}  // namespace tactus::firmware
