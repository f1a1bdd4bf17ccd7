// XmlText: a text as it stands in XML or HTML, between tags or in an attribute. Escaped: a text with some of
// its letters written otherwise. Pure; any thread.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace skyquilt {

std::string Escaped(std::string_view text, std::initializer_list<std::pair<char, std::string_view>> escapes);
std::string XmlText(std::string_view text);

}  // namespace skyquilt
