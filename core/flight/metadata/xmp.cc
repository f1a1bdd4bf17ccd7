#include "core/flight/metadata/xmp.h"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kMaxPacket = 1u << 20;
// Of one element: tinyxml2 compares each attribute with all before it. Cameras write up to a hundred.
constexpr std::size_t kMaxAttributes = 400;
constexpr std::size_t kMaxElements = 20'000;
constexpr std::size_t kMaxName = 200;
constexpr std::size_t kMaxProperties = 4000;
constexpr std::size_t kMaxText = 256u << 10;
constexpr int kMaxDepth = 32;

struct KnownNamespace {
  std::string_view uri;  // lower case, without scheme, "www." and closing slash
  std::string_view prefix;
};
constexpr std::string_view kRdf = "rdf";
constexpr std::array kKnownNamespaces = {
    KnownNamespace{"w3.org/1999/02/22-rdf-syntax-ns#", kRdf},
    KnownNamespace{"dji.com/drone-dji/1.0", "drone-dji"},
    KnownNamespace{"parrot.com/drone-parrot/1.0", "drone-parrot"},
    KnownNamespace{"pix4d.com/camera/1.0", "Camera"},
    KnownNamespace{"ns.sensefly.com/sensefly/1.0", "sensefly"},
    KnownNamespace{"ns.sensefly.com/camera/1.0", "Camera"},
    KnownNamespace{"skydio.com/drone-skydio/1.0", "drone-skydio"},
    KnownNamespace{"yuneec.com/drone-yuneec/1.0", "drone-yuneec"},
    KnownNamespace{"micasense.com/micasense/1.0", "MicaSense"},
    KnownNamespace{"micasense.com/dls/1.0", "DLS"},
    KnownNamespace{"ns.adobe.com/exif/1.0", "exif"},
    KnownNamespace{"ns.adobe.com/tiff/1.0", "tiff"},
    KnownNamespace{"ns.adobe.com/xap/1.0", "xmp"},
    KnownNamespace{"ns.google.com/photos/1.0/panorama", "GPano"},
    KnownNamespace{"ns.flir.com/flir/1.0", "FLIR"},
};

std::string NormalUri(std::string_view uri) {
  std::string lower = LowerCase(uri);
  for (const std::string_view start : {"https://", "http://", "www."}) {
    if (lower.starts_with(start)) lower.erase(0, start.size());
  }
  while (!lower.empty() && lower.back() == '/') lower.pop_back();
  return lower;
}

std::string Trimmed(std::string_view text) { return std::string(Trim(text).substr(0, kMaxText)); }

// Where what begins at `at` ends, if it is none that has attributes: a comment, CDATA, a declaration.
std::optional<std::size_t> EndOfOther(std::string_view packet, std::size_t at) {
  constexpr std::pair<std::string_view, std::string_view> kOthers[] = {
      {"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}, {"<!", ">"}};
  for (const auto& [open, close] : kOthers) {
    if (packet.substr(at, open.size()) != open) continue;
    const std::size_t end = packet.find(close, at + open.size());
    return end == std::string_view::npos ? packet.size() : end + close.size();
  }
  return std::nullopt;
}

// Whether a packet has no more elements and attributes than it may: one look at each byte, before a parser
// builds anything of it.
bool IsModest(std::string_view packet) {
  std::size_t elements = 0;
  for (std::size_t at = packet.find('<'); at != std::string_view::npos; at = packet.find('<', at)) {
    if (++elements > kMaxElements) return false;
    if (const auto end = EndOfOther(packet, at)) {
      at = *end;
      continue;
    }
    std::size_t attributes = 0;
    char quote = 0;
    for (++at; at < packet.size() && (quote != 0 || packet[at] != '>'); ++at) {
      if (quote == 0 && packet[at] == '=' && ++attributes > kMaxAttributes) return false;
      if (quote == 0 && (packet[at] == '"' || packet[at] == '\'')) {
        quote = packet[at];
      } else if (packet[at] == quote) {
        quote = 0;
      }
    }
  }
  return true;
}

// Walks the elements with the namespace declarations in force.
class PropertyWalker {
 public:
  explicit PropertyWalker(std::map<std::string, std::string, std::less<>>& values) : values_(values) {}

  // The children of rdf:Description are properties; everything above is wrapping. Yuneec's CGO3+ leaves
  // rdf:Description out.
  void WalkWrapping(const tinyxml2::XMLElement& element, int depth) {
    if (depth > kMaxDepth) return;
    const std::size_t scope = PushNamespaces(element);
    const std::string name = NormalName(element.Name());
    if (name == "rdf:Description") {
      WalkDescription(element, "", depth);
    } else {
      for (auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
        const bool is_property = name == "rdf:RDF" && child->FirstChildElement() == nullptr &&
                                 !IsBookkeeping(NormalName(child->Name()));
        if (is_property) {
          WalkProperty(*child, "", depth + 1);
        } else {
          WalkWrapping(*child, depth + 1);
        }
      }
    }
    declared_.resize(scope);
  }

 private:
  std::size_t PushNamespaces(const tinyxml2::XMLElement& element) {
    const std::size_t scope = declared_.size();
    for (auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
      const std::string_view name = attribute->Name();
      if (!name.starts_with("xmlns:") || declared_.size() >= 256) continue;
      const std::string uri = NormalUri(attribute->Value());
      const auto known = std::find_if(kKnownNamespaces.begin(), kKnownNamespaces.end(),
                                      [&](const KnownNamespace& k) { return k.uri == uri; });
      const std::string_view own = name.substr(6);
      declared_.emplace_back(own, known == kKnownNamespaces.end() ? own : known->prefix);
    }
    return scope;
  }

  std::string NormalName(std::string_view name) const {
    const auto colon = name.find(':');
    if (colon == std::string_view::npos) return std::string(name);
    const std::string_view prefix = name.substr(0, colon);
    const auto it = std::find_if(declared_.rbegin(), declared_.rend(),
                                 [&](const auto& pair) { return pair.first == prefix; });
    return (it == declared_.rend() ? std::string(prefix) : it->second) + std::string(name.substr(colon));
  }

  void Set(const std::string& name, std::string_view text) {
    if (values_.size() < kMaxProperties && name.size() < kMaxName) values_.emplace(name, Trimmed(text));
  }

  static bool IsBookkeeping(std::string_view name) {
    return name.starts_with("xmlns") || name.starts_with("rdf:") || name.starts_with("xml:");
  }

  void WalkDescription(const tinyxml2::XMLElement& element, const std::string& outer, int depth) {
    for (auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
      const std::string name = NormalName(attribute->Name());
      if (!IsBookkeeping(name)) Set(outer + name, attribute->Value());
    }
    for (auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
      WalkProperty(*child, outer, depth + 1);
    }
  }

  void WalkProperty(const tinyxml2::XMLElement& element, const std::string& outer, int depth) {
    // Names of structures are put before those of their fields: long ones would be copied for each.
    if (depth > kMaxDepth || outer.size() > kMaxName) return;
    const std::size_t scope = PushNamespaces(element);
    const std::string name = outer + NormalName(element.Name());
    const tinyxml2::XMLElement* child = element.FirstChildElement();
    // Fields of a structure in attribute form: <ns:Outer ns:Inner="1"/>.
    for (auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
      const std::string field = NormalName(attribute->Name());
      if (!IsBookkeeping(field)) Set(name + "/" + field, attribute->Value());
    }
    if (child == nullptr) {
      if (const char* text = element.GetText()) Set(name, text);
    } else {
      const std::string kind = NormalName(child->Name());
      if (kind == "rdf:Seq" || kind == "rdf:Bag" || kind == "rdf:Alt") {
        Set(name, JoinedItems(*child));
      } else if (kind == "rdf:Description") {
        const std::size_t inner_scope = PushNamespaces(*child);
        WalkDescription(*child, name + "/", depth + 1);
        declared_.resize(inner_scope);
      } else {  // rdf:parseType="Resource"
        for (; child; child = child->NextSiblingElement()) WalkProperty(*child, name + "/", depth + 1);
      }
    }
    declared_.resize(scope);
  }

  static std::string JoinedItems(const tinyxml2::XMLElement& list) {
    std::string joined;
    bool is_first = true;
    for (auto* item = list.FirstChildElement(); item && joined.size() < kMaxText;
         item = item->NextSiblingElement()) {
      if (!is_first) joined += ';';
      is_first = false;
      if (const char* text = item->GetText()) joined += Trimmed(text);
    }
    return joined;
  }

  std::map<std::string, std::string, std::less<>>& values_;
  std::vector<std::pair<std::string, std::string>> declared_;  // prefix in the file -> our prefix
};

}  // namespace

std::optional<double> ParseXmpNumber(std::string_view text) {
  const std::size_t slash = text.find('/');
  auto value = ParseNumber(text.substr(0, slash));
  if (value && slash != std::string_view::npos) {
    const auto denominator = ParseNumber(text.substr(slash + 1));
    value = denominator && *denominator != 0.0 ? std::optional(*value / *denominator) : std::nullopt;
  }
  return value && std::abs(*value) <= 1e9 ? value : std::nullopt;
}

std::vector<std::optional<double>> ParseXmpNumbers(std::string_view text) {
  constexpr std::size_t kMaxItems = 64;
  std::vector<std::optional<double>> items;
  while (!text.empty() && items.size() < kMaxItems) {
    const std::size_t end = text.find_first_of(",;");
    items.push_back(ParseXmpNumber(text.substr(0, end)));
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return items;
}

std::optional<std::vector<double>> AllXmpNumbers(std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::optional<double>& item : ParseXmpNumbers(text)) {
    if (!item) return std::nullopt;
    numbers.push_back(*item);
  }
  if (numbers.empty() || (count != 0 && numbers.size() != count)) return std::nullopt;
  return numbers;
}

bool XmpTags::AddPacket(std::string_view packet) {
  if (packet.size() > kMaxPacket) return false;
  // What stands around the element (the xpacket marks, padding, zero bytes) is none of XML's business.
  std::size_t begin = packet.find("<x:xmpmeta");
  std::string_view close = "</x:xmpmeta>";
  if (begin == std::string_view::npos) {
    begin = packet.find("<rdf:RDF");
    close = "</rdf:RDF>";
  }
  if (begin != std::string_view::npos) {
    const std::size_t end = packet.find(close, begin);
    packet = packet.substr(begin, end == std::string_view::npos ? end : end + close.size() - begin);
  }
  if (!IsModest(packet)) return false;
  tinyxml2::XMLDocument document;
  if (document.Parse(packet.data(), packet.size()) != tinyxml2::XML_SUCCESS || !document.RootElement())
    return false;
  PropertyWalker(values_).WalkWrapping(*document.RootElement(), 0);
  return true;
}

const std::string* XmpTags::Find(std::string_view name) const {
  const auto it = values_.find(name);
  return it == values_.end() ? nullptr : &it->second;
}

std::string XmpTags::Text(std::string_view name) const {
  const std::string* text = Find(name);
  return text ? *text : std::string();
}

namespace {

// "46,84260708" of programs that write numbers as their country does, with a point; nothing for what may be
// a list or thousands: with a point or a second comma, or three digits behind the one.
std::optional<std::string> WithPointForComma(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789";
  std::string number(Trim(text));
  const std::size_t comma = number.find(',');
  if (comma == std::string::npos) return std::nullopt;
  const std::size_t sign = number.starts_with('+') || number.starts_with('-') ? 1 : 0;
  const std::size_t behind = number.size() - comma - 1;
  if (comma <= sign || behind == 0 || behind == 3 || number.find_first_not_of(kDigits, sign) != comma ||
      number.find_first_not_of(kDigits, comma + 1) != std::string::npos)
    return std::nullopt;
  number[comma] = '.';
  return number;
}

}  // namespace

std::optional<double> XmpTags::Number(std::string_view name) const {
  const std::string* text = Find(name);
  if (!text) return std::nullopt;
  const auto with_point = WithPointForComma(*text);
  return ParseXmpNumber(with_point ? *with_point : *text);
}

std::string ScanForXmpPacket(ByteSource& source) {
  constexpr std::size_t kScanned = 2u << 20;
  const std::vector<std::uint8_t> bytes = source.ReadUpTo(0, kScanned);
  const std::string_view text = TextOf(bytes);
  const std::size_t begin = text.find("<x:xmpmeta");
  if (begin == std::string_view::npos) return "";
  constexpr std::string_view kClose = "</x:xmpmeta>";
  const std::size_t end = text.find(kClose, begin);
  if (end == std::string_view::npos) return "";
  return std::string(text.substr(begin, end + kClose.size() - begin));
}

std::optional<std::vector<std::uint8_t>> FromBase64(std::string_view text, std::size_t max_bytes) {
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  if (text.size() > 2 * max_bytes + 4) return std::nullopt;
  std::vector<std::uint8_t> bytes;
  std::uint32_t kept = 0;
  int bits = 0;
  bool has_ended = false;
  for (const char c : text) {
    if (IsBlank(c)) continue;
    if (c == '=') {
      has_ended = true;
      continue;
    }
    const std::size_t six = kAlphabet.find(c);
    if (six == std::string_view::npos || has_ended) return std::nullopt;
    kept = (kept << 6) | static_cast<std::uint32_t>(six);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    if (bytes.size() == max_bytes) return std::nullopt;
    bytes.push_back(static_cast<std::uint8_t>(kept >> bits));
  }
  return bytes;
}

}  // namespace skyquilt::flight
