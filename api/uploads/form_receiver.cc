#include "api/uploads/form_receiver.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "api/json/json_text.h"
#include "api/uploads/unpack.h"
#include "core/base/try.h"

namespace skyquilt::api {

Result<void> FormReceiver::Skip(const Error& error) {
  if (error.code == ErrorCode::kOutOfSpace || error.code == ErrorCode::kIo ||
      error.code == ErrorCode::kUnavailable || error.code == ErrorCode::kNotFound) {
    return error;
  }
  upload_.reset();
  incoming_.reset();
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
  const bool is_known = std::find(rules_.text_fields.begin(), rules_.text_fields.end(), header.field) !=
                        rules_.text_fields.end();
  if (!is_known && rules_.ignores_other_fields) return {};
  if (!is_known) {
    return Error{
        ErrorCode::kUnprocessable,
        fmt::format("The form field \"{0}\" is not known; known are {1} and files. To send a file, put an "
                    "@ before its name: curl -F \"{0}=@PHOTO.JPG\" ...",
                    header.field, fmt::join(rules_.text_fields, ", "))};
  }
  const auto [text, is_new] = texts_.try_emplace(header.field);
  if (!is_new) {
    return Error{ErrorCode::kUnprocessable, fmt::format("The form field \"{}\" comes twice.", header.field)};
  }
  text_ = &text->second;
  return {};
}

Result<void> FormReceiver::BeginFile(const std::string& name) {
  file_name_ = name;
  if (flight_id_.empty()) {
    return Skip({ErrorCode::kUnprocessable, "No files can be sent with this form."});
  }
  // A form whose file box was left empty sends a part without a name; its bytes, if any, are refused at its
  // end.
  const Result<void> named = name.empty() ? Result<void>() : storage::CheckFileName(name);
  if (!named) return Skip(named.error());
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service_, flight_id_));
  Result<storage::Upload> upload = service_.store.Begin(flight_id_, 0);
  if (!upload) return Skip(upload.error());
  upload_ = *std::move(upload);
  incoming_.emplace(std::move(incoming));
  return {};
}

Result<void> FormReceiver::PartBytes(std::span<const std::uint8_t> bytes) {
  if (is_file_) {
    if (is_skipped_) return {};
    SKYQUILT_TRY(incoming_->Take(static_cast<std::int64_t>(bytes.size())));
    const Result<void> written = upload_->Write(bytes);
    return written ? written : Skip(written.error());
  }
  if (text_ == nullptr) return {};
  if (text_->size() + bytes.size() > kMaxJsonBytes) {
    return Error{ErrorCode::kTooLarge, "A text field of the form is longer than 64 KiB."};
  }
  text_->append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return {};
}

Result<void> FormReceiver::EndPart() {
  if (!is_file_ || is_skipped_) return {};
  Result<void> ended = EndFile();
  upload_.reset();
  incoming_.reset();
  return ended;
}

std::optional<std::string> FormReceiver::Text(std::string_view field) const {
  const auto found = texts_.find(field);
  if (found == texts_.end()) return std::nullopt;
  return found->second;
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
    service_.store.TakeBack(flight_id_, *stored, added.error());
    return added.error();
  }
  incoming_->Kept(bytes);
  Result<std::vector<FileOutcome>> outcomes = UnpackStored(service_, flight_id_, *added);
  const bool is_full = !outcomes && outcomes.error().code == ErrorCode::kTooLarge;  // the quota
  if (!outcomes) return is_full ? outcomes.error() : Skip(outcomes.error());
  for (FileOutcome& outcome : *outcomes) {
    if (outcome.name == added->name && added->name != file_name_) {
      outcome.note =
          fmt::format("\"{}\" was there already, so this one is kept as \"{}\".", file_name_, added->name);
    }
    stored_count_ += outcome.error ? 0 : 1;
    files_.push_back(std::move(outcome));
  }
  return {};
}

}  // namespace skyquilt::api
