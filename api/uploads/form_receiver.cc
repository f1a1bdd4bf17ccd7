#include "api/uploads/form_receiver.h"

#include <fmt/format.h>

#include <utility>

#include "api/json_text.h"

namespace skyquilt::api {

Result<void> FormReceiver::Skip(const Error& error) {
  if (error.code == ErrorCode::kOutOfSpace || error.code == ErrorCode::kIo ||
      error.code == ErrorCode::kUnavailable || error.code == ErrorCode::kNotFound) {
    return error;
  }
  upload_.reset();
  is_skipped_ = true;
  FileOutcome outcome;
  outcome.name = file_name_;
  outcome.error = error;
  files_.push_back(std::move(outcome));
  return {};
}

Result<void> FormReceiver::BeginPart(const PartHeader& header) {
  is_file_ = header.file_name.has_value();
  is_skipped_ = false;
  text_ = nullptr;
  if (is_file_) return BeginFile(*header.file_name);
  text_ = header.field == "name" ? &name_ : header.field == "options" ? &options_ : nullptr;
  if (text_ == nullptr) {
    return Error{
        ErrorCode::kUnprocessable,
        fmt::format("The form field \"{}\" is not known; known are name, options and files.", header.field),
        ""};
  }
  if (text_->has_value()) {
    return Error{ErrorCode::kUnprocessable, fmt::format("The form field \"{}\" comes twice.", header.field),
                 ""};
  }
  text_->emplace();
  return {};
}

Result<void> FormReceiver::BeginFile(const std::string& name) {
  file_name_ = name;
  // A form whose file box was left empty sends a part without a name; its bytes, if any, are refused at its
  // end.
  const Result<void> named = name.empty() ? Result<void>() : storage::CheckFileName(name);
  if (!named) return Skip(named.error());
  Result<storage::Upload> upload = service_.store.Begin(flight_id_, 0);
  if (!upload) return Skip(upload.error());
  upload_ = *std::move(upload);
  return {};
}

Result<void> FormReceiver::PartBytes(std::span<const std::uint8_t> bytes) {
  if (is_file_) {
    if (is_skipped_) return {};
    const Result<void> written = upload_->Write(bytes);
    return written ? written : Skip(written.error());
  }
  if ((*text_)->size() + bytes.size() > kMaxJsonBytes) {
    return Error{ErrorCode::kTooLarge, "A text field of the form is longer than 64 KiB.", ""};
  }
  (*text_)->append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return {};
}

Result<void> FormReceiver::EndPart() {
  if (!is_file_ || is_skipped_) return {};
  const Result<void> ended = EndFile();
  upload_.reset();
  return ended;
}

Result<void> FormReceiver::EndFile() {
  const std::int64_t bytes = upload_->bytes();
  if (file_name_.empty()) {
    if (bytes == 0) return {};
    return Skip(storage::CheckFileName(file_name_).error());
  }
  const Result<std::string> stored = upload_->Finish();
  if (!stored) return Skip(stored.error());
  const Result<storage::StoredFile> added =
      service_.catalogue.AddFileUnderFreeName(flight_id_, {file_name_, *stored, bytes}, storage::Now());
  if (!added) {
    service_.store.Remove(flight_id_, *stored);
    return added.error();
  }
  FileOutcome outcome;
  outcome.name = added->name;
  outcome.bytes = bytes;
  if (added->name != file_name_) {
    outcome.note =
        fmt::format("\"{}\" was there already, so this one is kept as \"{}\".", file_name_, added->name);
  }
  files_.push_back(std::move(outcome));
  ++stored_count_;
  return {};
}

}  // namespace skyquilt::api
