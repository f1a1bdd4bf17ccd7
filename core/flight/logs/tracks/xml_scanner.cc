#include "core/flight/logs/tracks/xml_scanner.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestTag = 1024;
constexpr std::size_t kLongestWords = 256;
constexpr std::string_view kXmlBlanks = " \t\r\n";

std::string_view WithoutPrefix(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// What "amp" or "#65" stands for. Of numbers only ASCII: all else is neither a number nor a time.
char CharacterOf(std::string_view entity) {
  constexpr std::array<std::pair<std::string_view, char>, 5> kNamed = {
      {{"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}}};
  for (const auto& [name, character] : kNamed) {
    if (entity == name) return character;
  }
  if (!entity.starts_with('#')) return '?';
  entity.remove_prefix(1);
  const bool is_hex = entity.starts_with('x');
  if (is_hex) entity.remove_prefix(1);
  unsigned code = 0;
  const auto [end, error] =
      std::from_chars(entity.data(), entity.data() + entity.size(), code, is_hex ? 16 : 10);
  const bool is_ascii =
      error == std::errc() && end == entity.data() + entity.size() && code > 0 && code < 128;
  return is_ascii ? static_cast<char>(code) : '?';
}

std::string WithoutEntities(std::string_view text) {
  constexpr std::size_t kLongestEntity = 10;
  std::string plain;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end =
        text[at] == '&' ? text.substr(0, at + kLongestEntity).find(';', at) : std::string_view::npos;
    if (end == std::string_view::npos) {
      plain += text[at++];
    } else {
      plain += CharacterOf(text.substr(at + 1, end - at - 1));
      at = end + 1;
    }
  }
  return plain;
}

}  // namespace

void XmlScanner::AddWords(std::string_view text, bool has_entities) {
  if (words_.size() >= kLongestWords) return;
  text = text.substr(0, kLongestWords - words_.size());
  words_ += has_entities ? WithoutEntities(text) : std::string(text);
}

// Passes what begins with `open` at this place, up to and with `close` or to the end.
bool XmlScanner::Skip(std::string_view open, std::string_view close, bool is_words) {
  if (!text_.substr(at_).starts_with(open)) return false;
  const std::size_t begin = at_ + open.size();
  const std::size_t end = std::min(text_.find(close, begin), text_.size());
  if (is_words) AddWords(text_.substr(begin, end - begin), false);
  at_ = std::min(end + close.size(), text_.size());
  return true;
}

// The tag at this place. False for what is none; the next < is where to go on then.
bool XmlScanner::TakeTag() {
  const std::size_t begin = at_ + 1;
  char quote = 0;
  for (at_ = begin; at_ < text_.size() && text_[at_] != '<'; ++at_) {
    const char c = text_[at_];
    if (quote == 0 && c == '>') break;
    if (quote == 0 && (c == '"' || c == '\'')) {
      quote = c;
    } else if (c == quote) {
      quote = 0;
    }
  }
  if (at_ >= text_.size() || text_[at_] == '<') return false;
  std::string_view tag = text_.substr(begin, at_ - begin);
  ++at_;
  if (tag.starts_with('!') || tag.starts_with('?')) return false;
  opens_ = !tag.starts_with('/');
  if (!opens_) tag.remove_prefix(1);
  closes_itself_ = opens_ && tag.ends_with('/');
  if (closes_itself_) tag.remove_suffix(1);
  const std::size_t end = std::min(tag.find_first_of(kXmlBlanks), tag.size());
  name_ = WithoutPrefix(tag.substr(0, end));
  attributes_ = tag.substr(end);
  closes_itself_ = closes_itself_ && !name_.empty();
  return !name_.empty();
}

bool XmlScanner::Next() {
  if (std::exchange(closes_itself_, false)) {
    opens_ = false;
    words_.clear();
    return true;
  }
  words_.clear();
  while (at_ < text_.size()) {
    const std::size_t tag = std::min(text_.find('<', at_), text_.size());
    AddWords(text_.substr(at_, tag - at_), true);
    at_ = tag;
    if (at_ == text_.size()) break;
    if (Skip("<!--", "-->", false) || Skip("<![CDATA[", "]]>", true) || Skip("<?", "?>", false)) continue;
    if (TakeTag()) return true;
  }
  return false;
}

std::optional<std::string> XmlScanner::Attribute(std::string_view name) const {
  const std::string_view tag = attributes_.substr(0, kLongestTag);
  std::size_t at = 0;
  while (at < tag.size()) {
    const std::size_t equals = tag.find('=', at);
    if (equals == std::string_view::npos) return std::nullopt;
    const std::size_t quote = std::min(tag.find_first_not_of(kXmlBlanks, equals + 1), tag.size());
    if (quote == tag.size() || (tag[quote] != '"' && tag[quote] != '\'')) {
      at = equals + 1;
      continue;
    }
    const std::size_t end = tag.find(tag[quote], quote + 1);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view before = Trim(tag.substr(at, equals - at));
    const std::size_t blank = before.find_last_of(kXmlBlanks);
    if (WithoutPrefix(before.substr(blank == std::string_view::npos ? 0 : blank + 1)) == name)
      return WithoutEntities(tag.substr(quote + 1, end - quote - 1));
    at = end + 1;
  }
  return std::nullopt;
}

std::string_view XmlScanner::words() const { return Trim(words_); }

std::string_view XmlRootName(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (!Trim(text).starts_with('<')) return {};
  XmlScanner xml(text);
  return xml.Next() && xml.opens() ? xml.name() : std::string_view();
}

}  // namespace skyquilt::flight
