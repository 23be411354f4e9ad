#include "firmware/boards/linux_usb/usb_gadget.h"

#include <fcntl.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <vector>

namespace tactus::firmware {
namespace {

namespace fs = std::filesystem;

constexpr long kFunctionFsMagic = 0x0a647361;
constexpr char kGadgets[] = "/sys/kernel/config/usb_gadget";
constexpr char kControllers[] = "/sys/class/udc";
constexpr char kLanguage[] = "/strings/0x409";
constexpr char kConfig[] = "/configs/c.1";

std::string reason() { return std::strerror(errno); }

// Returns the error; empty: none.
std::string write_text(const std::string& path, std::string_view text) {
  const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) return path + ": " + reason();
  const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const std::string error = written ? "" : path + ": '" + std::string(text) + "' refused: " + reason();
  close(file);
  return error;
}

std::string make_folder(const std::string& path) {
  if (mkdir(path.c_str(), 0755) == 0 || errno == EEXIST) return "";
  return path + ": " + reason();
}

std::string make_link(const std::string& target, const std::string& path) {
  if (symlink(target.c_str(), path.c_str()) == 0) return "";
  return path + ": " + reason();
}

std::string hex(std::uint16_t number) {
  char text[8];
  std::snprintf(text, sizeof text, "0x%04x", number);
  return text;
}

bool is_functionfs(const std::string& path) noexcept {
  struct statfs found {};
  return statfs(path.c_str(), &found) == 0 && found.f_type == kFunctionFsMagic;
}

std::string check_serial(const std::string& serial) {
  const bool printable = std::all_of(serial.begin(), serial.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (serial.empty() || serial.size() > 126 || !printable)
    return "serial '" + serial + "': accepted are 1 to 126 printable ASCII characters without spaces";
  return "";
}

}  // namespace

std::string UsbGadget::choose_udc(const std::string& wanted) {
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(kControllers, error)) found.push_back(entry.path().filename());
  std::sort(found.begin(), found.end());
  std::string names;
  for (const std::string& name : found) names += (names.empty() ? "" : ", ") + name;
  if (found.empty())
    return "this board has no USB device controller (" + std::string(kControllers) +
           " is empty): load its driver, or set the port to device mode";
  if (wanted.empty() && found.size() > 1) return "several USB device controllers, choose one with --udc: " + names;
  if (!wanted.empty() && std::find(found.begin(), found.end(), wanted) == found.end())
    return "no USB device controller '" + wanted + "'; there are: " + names;
  udc_ = wanted.empty() ? found.front() : wanted;
  return "";
}

std::string UsbGadget::fill(const GadgetOptions& options) {
  const std::string g = gadget_;
  const std::string function = g + "/functions/ffs." + name_;
  std::string error;
  const auto text = [&](const char* where, std::string_view what) {
    if (error.empty()) error = write_text(g + where, what);
  };
  const auto folder = [&](const std::string& path) {
    if (error.empty()) error = make_folder(path);
  };
  text("/idVendor", hex(options.vendor));
  text("/idProduct", hex(options.product_id));
  text("/bcdDevice", hex(kUsbDeviceRelease));
  text("/bcdUSB", "0x0200");
  folder(g + kLanguage);
  text("/strings/0x409/serialnumber", options.serial);
  text("/strings/0x409/manufacturer", options.manufacturer);
  text("/strings/0x409/product", options.product);
  folder(g + kConfig);
  text("/configs/c.1/bmAttributes", "0xc0");  // self-powered
  text("/configs/c.1/MaxPower", "2");
  folder(function);
  if (error.empty()) error = make_link(function, g + kConfig + ("/ffs." + name_));
  text("/os_desc/use", "1");
  text("/os_desc/b_vendor_code", hex(kUsbMicrosoftVendorCode));
  text("/os_desc/qw_sign", "MSFT100");
  if (error.empty()) error = make_link(g + kConfig, g + "/os_desc/c.1");
  return error;
}

std::string UsbGadget::create(const GadgetOptions& options) {
  remove();
  if (std::string error = check_serial(options.serial); !error.empty()) return error;
  if (geteuid() != 0) return "a USB gadget is set up through configfs: run as root";
  if (access(kGadgets, W_OK) != 0)
    return std::string(kGadgets) + ": " + reason() + "; mount configfs and load the module libcomposite";
  if (std::string error = choose_udc(options.udc); !error.empty()) return error;

  name_ = options.name;
  mount_ = options.mount;
  gadget_ = std::string(kGadgets) + "/" + name_;
  remove();  // remains of an earlier run
  gadget_ = std::string(kGadgets) + "/" + name_;
  std::string error = make_folder(gadget_);
  if (error.empty()) error = fill(options);
  if (error.empty()) {
    std::error_code ignored;
    fs::create_directories(mount_, ignored);
    if (mount(name_.c_str(), mount_.c_str(), "functionfs", MS_NOSUID | MS_NODEV | MS_NOEXEC, nullptr) != 0)
      error = "mounting FunctionFS on " + mount_ + ": " + reason() + "; load the module usb_f_fs";
  }
  if (!error.empty()) remove();
  return error;
}

std::string UsbGadget::bind() {
  std::string error = write_text(gadget_ + "/UDC", udc_);
  if (!error.empty()) error += " (is another gadget bound to " + udc_ + "?)";
  return error;
}

void UsbGadget::unbind() noexcept {
  if (gadget_.empty()) return;
  const int file = open((gadget_ + "/UDC").c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  [[maybe_unused]] const ssize_t written = write(file, "\n", 1);  // ENODEV if it was not bound
  close(file);
}

void UsbGadget::remove() noexcept {
  if (gadget_.empty()) return;
  unbind();
  if (is_functionfs(mount_)) umount2(mount_.c_str(), MNT_DETACH);
  unlink((gadget_ + "/os_desc/c.1").c_str());
  unlink((gadget_ + kConfig + "/ffs." + name_).c_str());
  rmdir((gadget_ + kConfig).c_str());
  rmdir((gadget_ + "/functions/ffs." + name_).c_str());
  rmdir((gadget_ + kLanguage).c_str());
  rmdir(gadget_.c_str());
  gadget_.clear();
}

}  // namespace tactus::firmware
