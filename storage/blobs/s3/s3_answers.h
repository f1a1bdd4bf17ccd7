// What S3 says in XML, and the one document that is said to it. The answers are foreign bytes: whatever they
// are, these functions take time in proportion to their length, and believe no key that lies outside what
// was asked for, no length below zero and no more entries than a page may have. Pure. Error: kCorrupt.
// Source: Amazon S3 API Reference (ListObjectsV2, CreateMultipartUpload, error responses).
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::storage {

inline constexpr std::size_t kMaxPageEntries = 1000;

struct ListedObject {
  std::string key;  // whole, the store's prefix included
  std::int64_t bytes = 0;
  std::chrono::system_clock::time_point changed;
};

struct ListedPage {
  std::vector<ListedObject> objects;
  std::string next;  // the token of the page after this one; empty: there is none
};

struct S3Refusal {
  std::string code;  // "NoSuchKey"
  std::string message;
  std::string region;  // where the bucket really is; as a rule empty
};

struct UploadedPart {
  int number = 0;  // from 1
  std::string etag;
  std::int64_t bytes = 0;
};

// `prefix`: what was asked for; an answer with other keys is refused.
Result<ListedPage> ParseListedPage(std::string_view xml, std::string_view prefix);
// Of CreateMultipartUpload.
Result<std::string> ParseUploadId(std::string_view xml);
// Of CopyObject.
Result<std::string> ParseCopiedEtag(std::string_view xml);
// Absent: it is no error document. A 200 may hold one (CompleteMultipartUpload, copies).
std::optional<S3Refusal> ParseRefusal(std::string_view xml);

// Of DeleteObjects: the first key that was not removed; absent: all are gone.
std::optional<S3Refusal> ParseDeletionRefusal(std::string_view xml);

// Keys as they are.
std::string DeletionXml(const std::vector<std::string>& keys);
std::string CompletionXml(const std::vector<UploadedPart>& parts);

}  // namespace skyquilt::storage
