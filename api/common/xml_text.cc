#include "api/common/xml_text.h"

#include "api/http/responses.h"

namespace skyquilt::api {

std::string XmlText(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&apos;";
        break;
      default:
        // XML 1.0 has no way to say a control character.
        escaped += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return escaped;
}

Response Xml(std::string body, const char* content_type) {
  return NoCache(Text(200, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + std::move(body), content_type));
}

}  // namespace skyquilt::api
