// What the kernel would parse, parsed here: lengths add up, and every field says what usb_interface.h promises.
#include "firmware/boards/linux_usb/usb_descriptors.h"

#include <catch2/catch.hpp>
#include <string_view>

#include "firmware/usb_interface.h"

using namespace tactus::firmware;

namespace {

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  std::uint32_t next(unsigned size) {
    REQUIRE(at_ + size <= bytes_.size());
    std::uint32_t value = 0;
    for (unsigned i = 0; i < size; ++i)
      value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes_[at_++])) << (8 * i);
    return value;
  }
  std::string_view text(std::size_t size) {
    REQUIRE(at_ + size <= bytes_.size());
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  std::size_t at() const { return at_; }
  bool done() const { return at_ == bytes_.size(); }

 private:
  std::string_view bytes_;
  std::size_t at_{0};
};

void check_speed(Reader& in, std::uint32_t interval) {
  CHECK(in.next(1) == 9);
  CHECK(in.next(1) == 4);         // interface
  CHECK(in.next(3) == 2u << 16);  // number, alternate setting, two endpoints
  CHECK(in.next(1) == 0xff);
  CHECK(in.next(1) == kMagic);
  CHECK(in.next(1) == kProtocolVersion);
  CHECK(in.next(1) == 1);  // first string
  for (const std::uint32_t address : {0x81u, 0x02u}) {
    CHECK(in.next(1) == 7);
    CHECK(in.next(1) == 5);  // endpoint
    CHECK(in.next(1) == address);
    CHECK(in.next(1) == 3);  // interrupt
    CHECK(in.next(2) == 64);
    CHECK(in.next(1) == interval);
  }
}

}  // namespace

TEST_CASE("USB: the descriptors have an interface and two interrupt endpoints at each speed, and WINUSB",
          "[firmware]") {
  const std::string blob = functionfs_descriptors();
  Reader in(blob);
  CHECK(in.next(4) == 3);            // version 2 of the format
  CHECK(in.next(4) == blob.size());  // of all
  CHECK(in.next(4) == (1 | 2 | 8));  // full speed, high speed, Microsoft OS
  CHECK(in.next(4) == 3);
  CHECK(in.next(4) == 3);
  CHECK(in.next(4) == 2);
  check_speed(in, 1);
  check_speed(in, 1);

  std::size_t begin = in.at();
  in.next(1);
  const std::uint32_t compatible_size = in.next(4);
  CHECK(in.next(2) == 1);
  CHECK(in.next(2) == 4);  // extended compatible ID
  CHECK(in.next(2) == 1);
  in.next(1);
  CHECK(in.next(1) == 1);
  CHECK(in.text(8) == std::string_view("WINUSB\0\0", 8));
  CHECK(in.text(14) == std::string(14, '\0'));
  CHECK(in.at() - begin == compatible_size);

  begin = in.at();
  in.next(1);
  const std::uint32_t property_size = in.next(4);
  CHECK(in.next(2) == 1);
  CHECK(in.next(2) == 5);  // extended properties
  CHECK(in.next(2) == 1);
  CHECK(in.next(4) == property_size - 11);
  CHECK(in.next(4) == 1);  // a string
  CHECK(in.text(in.next(2)) == std::string_view("DeviceInterfaceGUID\0", 20));
  const std::string_view guid = in.text(in.next(4));
  REQUIRE(guid.size() == 39);  // {8-4-4-4-12} and the final zero
  for (const std::size_t dash : {9u, 14u, 19u, 24u}) CHECK(guid[dash] == '-');
  CHECK(guid[37] == '}');
  CHECK(guid[38] == '\0');
  CHECK(in.at() - begin == property_size);
  CHECK(in.done());
}

TEST_CASE("USB: the strings' lengths add up", "[firmware]") {
  const std::string blob = functionfs_strings();
  Reader in(blob);
  CHECK(in.next(4) == 2);
  CHECK(in.next(4) == blob.size());
  CHECK(in.next(4) == 1);
  CHECK(in.next(4) == 1);
  CHECK(in.next(2) == 0x0409);
  CHECK(blob.back() == '\0');
  CHECK(blob.find('\0', in.at()) == blob.size() - 1);
}
