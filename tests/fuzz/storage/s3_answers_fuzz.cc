// What a store of objects answers, and what a credentials service and file say.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "storage/blobs/s3/s3_answers.h"
#include "storage/blobs/s3/s3_credentials.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt::storage;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  if (const auto page = ParseListedPage(text, "a/")) {
    SKYQUILT_CHECK(page->objects.size() <= kMaxPageEntries, "a page of more than it may have");
    for (const ListedObject& object : page->objects)
      SKYQUILT_CHECK(object.key.starts_with("a/") && object.bytes >= 0, "an object that was not asked for");
  }
  (void)ParseUploadId(text).ok();
  (void)ParseCopiedEtag(text).ok();
  (void)ParseDeletionRefusal(text).has_value();
  (void)ParseRefusal(text).has_value();
  const auto answered = CredentialsInAnswer(text);
  SKYQUILT_CHECK(!answered || !answered->secret_key.empty(), "keys without a secret");
  const auto filed = CredentialsInFile(text, "default");
  SKYQUILT_CHECK(!filed || !filed->secret_key.empty(), "keys without a secret");
  return 0;
}
