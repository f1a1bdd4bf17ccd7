// FormDigest: the content of a form as one SHA-256: fields, file names and bytes in their order, independent
// of the boundary, because a client that sends its form again chooses another one. Passes the parts on as
// they arrive. One thread at a time.
#pragma once

#include <cstdint>
#include <string>

#include "api/forms/multipart.h"
#include "api/http/digest.h"

namespace skyquilt::api {

class FormDigest final : public PartReceiver {
 public:
  // `next` takes the parts; none: they are only looked at.
  explicit FormDigest(PartReceiver* next) : next_(next) {}

  Result<void> BeginPart(const PartHeader& header) override;
  Result<void> PartBytes(std::span<const std::uint8_t> bytes) override;
  Result<void> EndPart() override;
  // Once, at the end.
  std::string Finish() { return digest_.Finish(); }

 private:
  void AddText(const std::string& text);
  void AddNumber(std::uint64_t number);

  PartReceiver* next_;
  Digest digest_{DigestAlgorithm::kSha256};
  std::uint64_t part_bytes_ = 0;
};

}  // namespace skyquilt::api
