// Digest: SHA-256 (and, for protocols that ask for it, SHA-1) of bytes that come in pieces, and base64, as
// storage has both. One thread at a time.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "storage/blobs/sha256.h"

namespace skyquilt::api {

using Digest = storage::RawDigest;
using storage::DecodeBase64;
using storage::DigestAlgorithm;
using storage::EncodeBase64;
using storage::RawDigestOf;

// Content-Digest of RFC 9530: the raw SHA-256 out of "sha-256=:...:" (others beside it are left alone);
// absent when the header has none.
std::optional<std::string> Sha256OfContentDigest(std::string_view header);

}  // namespace skyquilt::api
