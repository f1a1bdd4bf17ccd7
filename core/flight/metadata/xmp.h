// XMP packets as a flat list of "prefix:Name" -> text, whatever prefix the writer chose: names go by
// namespace URI. Attribute and element form, rdf:Seq/Bag/Alt (items joined with ';'), and structures
// ("drone-skydio:Outer/Inner"). Bounded: packets up to 1 MiB of 20 000 elements with 400
// attributes each, 4000 properties, 32 deep. Any thread. Source: Adobe XMP specification part 1 (ISO
// 16684-1), section 7.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/bytes/byte_source.h"

namespace skyquilt::flight {

class XmpTags {
 public:
  // Adds the properties of one packet; those already there stay. False when it is not well-formed XML.
  bool AddPacket(std::string_view packet);

  bool empty() const { return values_.empty(); }
  const std::string* Find(std::string_view name) const;
  std::string Text(std::string_view name) const;
  // Plain numbers and fractions ("+198.31", "73/10", also "46,84260708"); nothing for what is not finite or a
  // sentinel beyond 1e9.
  std::optional<double> Number(std::string_view name) const;
  const std::map<std::string, std::string, std::less<>>& values() const { return values_; }

 private:
  std::map<std::string, std::string, std::less<>> values_;
};

// One number out of text, as XmpTags::Number reads it.
std::optional<double> ParseXmpNumber(std::string_view text);

// Numbers with ',' or ';' between them, as items of a list or in one text; nothing for others. At most 64.
std::vector<std::optional<double>> ParseXmpNumbers(std::string_view text);
// The same where all are numbers, and none is missing of `count` (0: any count); nothing otherwise.
std::optional<std::vector<double>> AllXmpNumbers(std::string_view text, std::size_t count = 0);

// The first XMP packet in the first 2 MiB, found by its "<x:xmpmeta": for files that keep it outside of the
// standard segments.
std::string ScanForXmpPacket(ByteSource& source);

// Bytes that cameras write as text into their tags (RFC 4648, with or without its padding). Blanks and line
// ends may stand anywhere, '=' only at the end. Nothing for other characters or for more than `max_bytes`.
std::optional<std::vector<std::uint8_t>> FromBase64(std::string_view text, std::size_t max_bytes);

}  // namespace skyquilt::flight
