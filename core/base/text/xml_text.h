// XmlText: a text as it stands in XML or HTML, between tags or in an attribute. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

namespace skyquilt {

std::string XmlText(std::string_view text);

}  // namespace skyquilt
