// XmlScanner: the tags of an XML text one after the other, with the words of each element that holds no
// other, whatever prefix its namespace has. Nothing is built: each byte is looked at once, and what is
// damaged (a tag that another begins in) is passed over. Comments, declarations and their likes are skipped;
// CDATA and entities are words. One thread. Source: XML 1.0, Namespaces in XML 1.0.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace skyquilt::flight {

class XmlScanner {
 public:
  explicit XmlScanner(std::string_view text) : text_(text) {}

  // False at the end. An element that closes itself is given as opened and then as closed.
  bool Next();
  bool opens() const { return opens_; }
  // The tag's name without its prefix.
  std::string_view name() const { return name_; }
  // Of a tag that opens: the value of one of its attributes. Looks at the tag's first 1024 bytes.
  std::optional<std::string> Attribute(std::string_view name) const;
  // Of a tag that closes: what was said since the last tag before it, at most 256 bytes, trimmed.
  std::string_view words() const;
  std::size_t offset() const { return at_; }

 private:
  bool Skip(std::string_view open, std::string_view close, bool is_words);
  bool TakeTag();
  void AddWords(std::string_view text, bool has_entities);

  std::string_view text_;
  std::size_t at_ = 0;
  std::string_view name_;
  std::string_view attributes_;
  std::string words_;
  bool opens_ = false;
  bool closes_itself_ = false;
};

// The name of a text's outermost element without its prefix; empty where the text is no XML.
std::string_view XmlRootName(std::string_view text);

}  // namespace skyquilt::flight
