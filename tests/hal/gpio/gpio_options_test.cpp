#include "hal/gpio/gpio_options.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus::hal;

TEST_CASE("the text of --gpio names a chip and its lines, each optional, in any order") {
  const auto all = parse_gpio_options("chip=gpiochip0,estop=3-low,enable=4,probe=5,heartbeat=1023");
  REQUIRE(all.ok());
  CHECK(all.value().chip == "gpiochip0");
  CHECK(all.value().estop == GpioLine{3, true});
  CHECK(all.value().enable == GpioLine{4, false});
  CHECK(all.value().probe == GpioLine{5, false});
  CHECK(all.value().heartbeat == GpioLine{1023, false});

  const auto one = parse_gpio_options("probe=0,chip=/dev/gpiochip2");
  REQUIRE(one.ok());
  CHECK(one.value().chip == "/dev/gpiochip2");
  CHECK(one.value().probe == GpioLine{0, false});
  CHECK_FALSE((one.value().estop || one.value().enable || one.value().heartbeat));
}

TEST_CASE("what --gpio does not take is refused in one line that names it and what is taken") {
  const auto [text, named] = GENERATE(table<const char*, const char*>({
      {"", "names nothing"},
      {"gpiochip0", "'gpiochip0' names nothing"},
      {"estop=3", "names no chip"},
      {"chip=gpiochip0", "names no line"},
      {"chip=,estop=3", "'chip=' is empty"},
      {"chip=a,chip=b,estop=3", "'chip=b' is empty or comes twice"},
      {"chip=a,stop=3", "'stop=3' is not known"},
      {"chip=a,estop=3,", "'' names nothing"},
      {"chip=a,estop=", "'estop=' is no offset from 0 to 1023"},
      {"chip=a,estop=-low", "is no offset"},
      {"chip=a,estop=3low", "is no offset"},
      {"chip=a,estop=-3", "is no offset"},
      {"chip=a,estop= 3", "is no offset"},
      {"chip=a,estop=1024", "is no offset"},
      {"chip=a,estop=99999999999", "is no offset"},
      {"chip=a,estop=3,estop=4", "'estop=4' comes twice"},
      {"chip=a,estop=3,probe=3-low", "line 3 for both estop and probe"},
  }));
  const auto options = parse_gpio_options(text);
  INFO(text);
  REQUIRE_FALSE(options.ok());
  CHECK_THAT(options.message(), Catch::Contains(named) && Catch::Contains("accepted: chip=NAME"));
  CHECK(options.message().find('\n') == std::string::npos);
}

TEST_CASE("whatever text comes, the answer is lines of their own or an error") {
  std::mt19937_64 random(1);
  const std::string alphabet = "chip=estoprobenalhb,019-lw";
  for (int i = 0; i < 50000; ++i) {
    std::string text = random() % 2 == 0 ? "chip=c,estop=1" : "";
    for (auto left = random() % 24; left > 0; --left) text += alphabet[random() % alphabet.size()];
    const auto options = parse_gpio_options(text);
    if (!options.ok()) continue;
    REQUIRE_FALSE(options.value().chip.empty());
    if (options.value().estop) REQUIRE(options.value().estop->offset <= kMaxGpioOffset);
  }
}
