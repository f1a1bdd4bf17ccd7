#include "core/base/text/xml_text.h"

#include <algorithm>

namespace skyquilt {

std::string Escaped(std::string_view text, std::initializer_list<std::pair<char, std::string_view>> escapes) {
  std::string escaped;
  for (const char c : text) {
    const auto* found =
        std::find_if(escapes.begin(), escapes.end(), [c](const auto& escape) { return escape.first == c; });
    escaped += found != escapes.end() ? found->second : std::string_view(&c, 1);
  }
  return escaped;
}

std::string XmlText(std::string_view text) {
  std::string escaped =
      Escaped(text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}});
  // XML 1.0 has no way to say a control character.
  std::replace_if(
      escaped.begin(), escaped.end(), [](unsigned char c) { return c < 0x20 && c != '\n' && c != '\t'; },
      ' ');
  return escaped;
}

}  // namespace skyquilt
