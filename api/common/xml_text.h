// XML put together as text. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

#include "api/http/http_message.h"

namespace skyquilt::api {

// For a text or an attribute.
std::string XmlText(std::string_view text);
// Which is not kept.
Response Xml(std::string body, const char* content_type = "application/xml");

}  // namespace skyquilt::api
