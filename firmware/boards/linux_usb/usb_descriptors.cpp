#include "firmware/boards/linux_usb/usb_descriptors.h"

#include <linux/usb/ch9.h>
#include <linux/usb/functionfs.h>

#include <string_view>

#include "firmware/usb_interface.h"

namespace tactus::firmware {
namespace {

constexpr std::uint16_t kExtendedCompatId = 4, kExtendedProperties = 5, kOsDescriptorVersion = 1;
constexpr std::uint32_t kPropertyUnicodeString = 1;

void add(std::string& blob, std::uint32_t value, unsigned bytes) {
  for (unsigned i = 0; i < bytes; ++i) blob.push_back(static_cast<char>(value >> (8 * i) & 0xff));
}
void add8(std::string& blob, std::uint32_t value) { add(blob, value, 1); }
void add16(std::string& blob, std::uint32_t value) { add(blob, value, 2); }
void add32(std::string& blob, std::uint32_t value) { add(blob, value, 4); }

void add_endpoint(std::string& blob, std::uint8_t address, std::uint8_t interval) {
  add8(blob, USB_DT_ENDPOINT_SIZE);
  add8(blob, USB_DT_ENDPOINT);
  add8(blob, address);
  add8(blob, USB_ENDPOINT_XFER_INT);
  add16(blob, kUsbPacketSize);
  add8(blob, interval);
}

constexpr std::uint32_t kDescriptorsPerSpeed = 3;

std::string interface_and_endpoints(std::uint8_t interval) {
  std::string blob;
  add8(blob, USB_DT_INTERFACE_SIZE);
  add8(blob, USB_DT_INTERFACE);
  add8(blob, 0);  // the kernel inserts the real number
  add8(blob, 0);  // no alternate setting
  add8(blob, 2);
  add8(blob, kUsbInterfaceClass);
  add8(blob, kUsbInterfaceSubclass);
  add8(blob, kUsbInterfaceProtocol);
  add8(blob, 1);  // its name: first string
  add_endpoint(blob, kUsbStateEndpoint, interval);
  add_endpoint(blob, kUsbCommandEndpoint, interval);
  return blob;
}

// One feature descriptor for the interface, with one section in it.
std::string os_feature(std::uint16_t kind, const std::string& section) {
  constexpr std::uint32_t kHeaderSize = 11;
  std::string blob;
  add8(blob, 0);  // interface
  add32(blob, kHeaderSize + static_cast<std::uint32_t>(section.size()));
  add16(blob, kOsDescriptorVersion);
  add16(blob, kind);
  add16(blob, 1);  // sections
  return blob + section;
}

std::string compatible_id() {
  std::string section;
  add8(section, 0);  // first interface
  add8(section, 1);
  section += std::string_view("WINUSB\0\0", 8);
  section.append(8 + 6, '\0');  // no sub-compatible ID; reserved
  return os_feature(kExtendedCompatId, section);
}

// Names and values with their final zero; the kernel widens them to UTF-16.
std::string interface_guid() {
  constexpr std::string_view kName("DeviceInterfaceGUID\0", 20);
  constexpr std::string_view kValue(kUsbInterfaceGuid, sizeof kUsbInterfaceGuid);
  std::string section;
  add32(section, static_cast<std::uint32_t>(14 + kName.size() + kValue.size()));
  add32(section, kPropertyUnicodeString);
  add16(section, static_cast<std::uint32_t>(kName.size()));
  section += kName;
  add32(section, static_cast<std::uint32_t>(kValue.size()));
  section += kValue;
  return os_feature(kExtendedProperties, section);
}

}  // namespace

std::string functionfs_descriptors() {
  const std::string os_descriptors = compatible_id() + interface_guid();
  std::string counts;
  add32(counts, kDescriptorsPerSpeed);  // full speed
  add32(counts, kDescriptorsPerSpeed);  // high speed
  add32(counts, 2);                     // Microsoft OS
  const std::string body = counts + interface_and_endpoints(kUsbIntervalFullSpeed) +
                           interface_and_endpoints(kUsbIntervalHighSpeed) + os_descriptors;
  std::string blob;
  add32(blob, FUNCTIONFS_DESCRIPTORS_MAGIC_V2);
  add32(blob, static_cast<std::uint32_t>(12 + body.size()));
  add32(blob, FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC | FUNCTIONFS_HAS_MS_OS_DESC);
  return blob + body;
}

std::string functionfs_strings() {
  constexpr std::string_view kInterfaceName("tactus frames\0", 14);
  constexpr std::uint32_t kEnglish = 0x0409;
  std::string blob;
  add32(blob, FUNCTIONFS_STRINGS_MAGIC);
  add32(blob, static_cast<std::uint32_t>(18 + kInterfaceName.size()));
  add32(blob, 1);  // strings
  add32(blob, 1);  // languages
  add16(blob, kEnglish);
  blob += kInterfaceName;
  return blob;
}

}  // namespace tactus::firmware
