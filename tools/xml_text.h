// Text within XML, such as SVG: its special characters as entities, control characters, which XML has none of, as
// spaces. Thread: any normal one. Bound: the text. Errors: none but a lack of memory.
#pragma once

#include <string>
#include <string_view>

namespace tactus {

// For an element's content, and for an attribute in double quotes.
inline std::string xml_text(std::string_view words) {
  std::string text;
  for (const char c : words) {
    if (c == '&')
      text += "&amp;";
    else if (c == '<')
      text += "&lt;";
    else if (c == '>')
      text += "&gt;";
    else if (c == '"')
      text += "&quot;";
    else
      text += static_cast<unsigned char>(c) < 32 ? ' ' : c;
  }
  return text;
}

}  // namespace tactus
