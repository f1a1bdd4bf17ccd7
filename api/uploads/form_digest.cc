#include "api/uploads/form_digest.h"

#include <array>

namespace skyquilt::api {

void FormDigest::AddNumber(std::uint64_t number) {
  std::array<std::uint8_t, 8> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(number >> (8 * i));
  digest_.Add(bytes);
}

// With its length before it, so that no two forms add up to the same bytes.
void FormDigest::AddText(const std::string& text) {
  AddNumber(text.size());
  digest_.Add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Result<void> FormDigest::BeginPart(const PartHeader& header) {
  AddText(header.field);
  AddNumber(header.file_name ? 1 : 0);
  AddText(header.file_name.value_or(""));
  part_bytes_ = 0;
  return next_ == nullptr ? Result<void>() : next_->BeginPart(header);
}

Result<void> FormDigest::PartBytes(std::span<const std::uint8_t> bytes) {
  digest_.Add(bytes);
  part_bytes_ += bytes.size();
  return next_ == nullptr ? Result<void>() : next_->PartBytes(bytes);
}

Result<void> FormDigest::EndPart() {
  AddNumber(part_bytes_);
  return next_ == nullptr ? Result<void>() : next_->EndPart();
}

}  // namespace skyquilt::api
