#include "storage/blobs/s3/s3_answers.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include "core/base/text/plain_text.h"
#include "core/base/text/xml_text.h"
#include "core/base/try.h"
#include "storage/blobs/s3/s3_credentials.h"

namespace skyquilt::storage {
namespace {

constexpr std::size_t kMaxAnswerXmlBytes = std::size_t{8} << 20;
constexpr std::size_t kMaxKeyBytes = 1024;
constexpr std::size_t kMaxWordBytes = 4096;

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

Error Unreadable(const std::string& what) {
  return {ErrorCode::kCorrupt, "The store of objects answered something that is no answer of S3.", what};
}

// The document's root, which must have this name.
Result<const XMLElement*> RootOf(XMLDocument& document, std::string_view xml, const char* name) {
  if (xml.size() > kMaxAnswerXmlBytes) return Unreadable("too long");
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
    return Unreadable(document.ErrorName());
  const XMLElement* root = document.RootElement();
  if (root == nullptr || std::string_view(root->Name()) != name) return Unreadable(std::string("no ") + name);
  return root;
}

std::string TextOfElement(const XMLElement& element, const char* name, std::size_t max_bytes) {
  const XMLElement* child = element.FirstChildElement(name);
  const char* text = child == nullptr ? nullptr : child->GetText();
  const std::string_view found = text == nullptr ? "" : text;
  return found.size() <= max_bytes ? std::string(found) : "";
}

std::optional<std::int64_t> NumberIn(const XMLElement& element, const char* name) {
  const auto number = ParseNumber<std::int64_t>(TextOfElement(element, name, 20));
  return number && *number >= 0 ? number : std::nullopt;
}

// "2009-10-12T17:50:30.000Z"; the second is enough.
std::chrono::system_clock::time_point TimeIn(const XMLElement& element, const char* name) {
  std::string text = TextOfElement(element, name, 40);
  if (const std::size_t dot = text.find('.'); dot != std::string::npos) text = text.substr(0, dot) + "Z";
  return ParseUtc(text).value_or(std::chrono::system_clock::time_point());
}

bool IsTrue(const XMLElement& element, const char* name) { return TextOfElement(element, name, 8) == "true"; }

bool IsKeyBelow(const std::string& key, std::string_view prefix) {
  return !key.empty() && key.starts_with(prefix);
}

}  // namespace

Result<ListedPage> ParseListedPage(std::string_view xml, std::string_view prefix) {
  XMLDocument document;
  SKYQUILT_TRY_ASSIGN(const XMLElement* const root, RootOf(document, xml, "ListBucketResult"));
  ListedPage page;
  std::size_t count = 0;
  for (const XMLElement* entry = root->FirstChildElement("Contents"); entry != nullptr;
       entry = entry->NextSiblingElement("Contents")) {
    if (++count > kMaxPageEntries) return Unreadable("too many objects");
    const auto bytes = NumberIn(*entry, "Size");
    ListedObject object{TextOfElement(*entry, "Key", kMaxKeyBytes), bytes.value_or(0),
                        TimeIn(*entry, "LastModified")};
    if (!bytes || !IsKeyBelow(object.key, prefix)) return Unreadable("an object that was not asked for");
    page.objects.push_back(std::move(object));
  }
  if (IsTrue(*root, "IsTruncated")) {
    page.next = TextOfElement(*root, "NextContinuationToken", kMaxWordBytes);
    if (page.next.empty()) return Unreadable("a page without its end");
  }
  return page;
}

Result<std::string> ParseUploadId(std::string_view xml) {
  XMLDocument document;
  SKYQUILT_TRY_ASSIGN(const XMLElement* const root, RootOf(document, xml, "InitiateMultipartUploadResult"));
  std::string id = TextOfElement(*root, "UploadId", kMaxWordBytes);
  if (id.empty()) return Unreadable("an upload without id");
  return id;
}

Result<std::string> ParseCopiedEtag(std::string_view xml) {
  XMLDocument document;
  if (xml.size() > kMaxAnswerXmlBytes || document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
    return Unreadable("no copy");
  const XMLElement* root = document.RootElement();
  std::string etag = root == nullptr ? "" : TextOfElement(*root, "ETag", kMaxWordBytes);
  if (etag.empty()) return Unreadable("a copy without its tag");
  return etag;
}

std::optional<S3Refusal> ParseRefusal(std::string_view xml) {
  XMLDocument document;
  const Result<const XMLElement*> root = RootOf(document, xml, "Error");
  if (!root) return std::nullopt;
  S3Refusal refusal{TextOfElement(**root, "Code", 100), TextOfElement(**root, "Message", 1000),
                    TextOfElement(**root, "Region", 100)};
  if (refusal.code.empty()) return std::nullopt;
  return refusal;
}

std::optional<S3Refusal> ParseDeletionRefusal(std::string_view xml) {
  XMLDocument document;
  const Result<const XMLElement*> root = RootOf(document, xml, "DeleteResult");
  if (!root) return S3Refusal{"", root.error().detail, ""};
  const XMLElement* error = (*root)->FirstChildElement("Error");
  if (error == nullptr) return std::nullopt;
  return S3Refusal{TextOfElement(*error, "Code", 100), TextOfElement(*error, "Message", 1000), ""};
}

std::string DeletionXml(const std::vector<std::string>& keys) {
  std::string xml = "<Delete xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\"><Quiet>true</Quiet>";
  for (const std::string& key : keys) xml += fmt::format("<Object><Key>{}</Key></Object>", XmlText(key));
  return xml + "</Delete>";
}

std::string CompletionXml(const std::vector<UploadedPart>& parts) {
  std::string xml = "<CompleteMultipartUpload xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\">";
  for (const UploadedPart& part : parts) {
    xml += fmt::format("<Part><PartNumber>{}</PartNumber><ETag>{}</ETag></Part>", part.number,
                       XmlText(part.etag));
  }
  return xml + "</CompleteMultipartUpload>";
}

}  // namespace skyquilt::storage
