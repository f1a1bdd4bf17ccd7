// The headers of tus 1.0 as values. Pure. https://tus.io/protocols/resumable-upload
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/http/digest.h"

namespace skyquilt::api {

inline constexpr const char* kTusVersion = "1.0.0";

// Upload-Offset, Upload-Length: plain digits up to 2^53.
std::optional<std::int64_t> ParseTusNumber(std::string_view text);

// Upload-Metadata: "key base64,key base64"; a key alone has an empty value. Absent when it is not that, a key
// comes twice, or it is longer than 8 KiB.
std::optional<std::map<std::string, std::string>> ParseTusMetadata(std::string_view text);

struct TusChecksum {
  DigestAlgorithm algorithm = DigestAlgorithm::kSha1;
  std::string digest;  // raw
};
// Upload-Checksum: "sha1 base64" or "sha256 base64".
std::optional<TusChecksum> ParseTusChecksum(std::string_view text);

struct TusConcat {
  bool is_final = false;           // else it is a part
  std::vector<std::string> parts;  // ids, in order; of a final one
};
// Upload-Concat: "partial", or "final;" with the addresses of parts, a space between, of which the last
// segment of the path counts.
std::optional<TusConcat> ParseTusConcat(std::string_view text);

}  // namespace skyquilt::api
