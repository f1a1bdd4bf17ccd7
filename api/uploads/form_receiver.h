// FormReceiver: the parts of an upload form, as they come: files go to the photo store and the catalogue, the
// text fields "name" and "options" are collected. A file that cannot be taken is noted and skipped; a machine
// that is full stops the form. One thread at a time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/json_codec.h"
#include "api/multipart.h"
#include "api/service.h"

namespace skyquilt::api {

class FormReceiver final : public PartReceiver {
 public:
  FormReceiver(Service& service, std::string flight_id)
      : service_(service), flight_id_(std::move(flight_id)) {}

  Result<void> BeginPart(const PartHeader& header) override;
  Result<void> PartBytes(std::span<const std::uint8_t> bytes) override;
  Result<void> EndPart() override;

  const std::vector<FileOutcome>& files() const { return files_; }
  int stored_count() const { return stored_count_; }
  const std::optional<std::string>& name() const { return name_; }
  const std::optional<std::string>& options() const { return options_; }

 private:
  Result<void> BeginFile(const std::string& name);
  Result<void> EndFile();
  // Notes an error of this one file, or passes on one of the machine.
  Result<void> Skip(const Error& error);

  Service& service_;
  std::string flight_id_;
  std::optional<storage::Upload> upload_;
  std::optional<std::string>* text_ = nullptr;
  bool is_file_ = false;
  bool is_skipped_ = false;
  std::string file_name_;
  std::vector<FileOutcome> files_;
  int stored_count_ = 0;
  std::optional<std::string> name_;
  std::optional<std::string> options_;
};

}  // namespace skyquilt::api
