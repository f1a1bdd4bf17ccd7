// FormReceiver: receives the parts of an upload form: files go to the photo store and the catalogue, text
// fields are collected. A file that cannot be accepted is noted and skipped; a full disk or quota (kTooLarge)
// ends the form. One thread at a time.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/forms/multipart.h"
#include "api/json/json_codec.h"
#include "api/service.h"

namespace skyquilt::api {

struct FormRules {
  std::vector<std::string_view> text_fields = {"name", "options"};
  bool ignores_other_fields = false;  // else they are refused
};

class FormReceiver final : public PartReceiver {
 public:
  // Without a flight, files are refused.
  FormReceiver(Service& service, std::string flight_id, FormRules rules = {})
      : service_(service), flight_id_(std::move(flight_id)), rules_(std::move(rules)) {}

  Result<void> BeginPart(const PartHeader& header) override;
  Result<void> PartBytes(std::span<const std::uint8_t> bytes) override;
  Result<void> EndPart() override;

  const std::vector<FileOutcome>& files() const { return files_; }
  int stored_count() const { return stored_count_; }
  // A text field as sent; absent when the form has none of this name.
  std::optional<std::string> Text(std::string_view field) const;

 private:
  Result<void> BeginFile(const std::string& name);
  Result<void> EndFile();
  // Notes an error of this one file, or passes on one of the machine.
  Result<void> Skip(const Error& error);

  Service& service_;
  std::string flight_id_;
  FormRules rules_;
  std::optional<storage::Upload> upload_;
  std::optional<IncomingBytes> incoming_;  // for as long as there is an upload_
  std::string* text_ = nullptr;            // the field that is coming in; none: dropped
  bool is_file_ = false;
  bool is_skipped_ = false;
  std::string file_name_;
  std::vector<FileOutcome> files_;
  int stored_count_ = 0;
  std::map<std::string, std::string, std::less<>> texts_;
};

}  // namespace skyquilt::api
