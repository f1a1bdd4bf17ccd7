#include "storage/files/stream_file.h"

#include <cerrno>
#include <utility>

#include "storage/files/publish_file.h"

namespace skyquilt::storage {

Result<std::unique_ptr<StreamFile>> StreamFile::Create(const std::filesystem::path& path) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (file == nullptr) return FileError("cannot write", temporary, errno);
  return std::unique_ptr<StreamFile>(new StreamFile(path, std::move(temporary), file));
}

StreamFile::~StreamFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::error_code gone;  // nothing to do about a temporary file that will not go; the next run overwrites it
  std::filesystem::remove(temporary_, gone);
}

void StreamFile::Keep(bool went_well) {
  if (!went_well && failure_ == 0) failure_ = errno != 0 ? errno : EIO;
}

void StreamFile::Write(std::string_view bytes) {
  if (failure_ == 0) Keep(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size());
  position_ += bytes.size();
}

void StreamFile::WriteAt(std::uint64_t offset, std::string_view bytes) {
  if (failure_ != 0) return;
  Keep(fseeko(file_, static_cast<off_t>(offset), SEEK_SET) == 0);
  if (failure_ == 0) Keep(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size());
  if (failure_ == 0) Keep(fseeko(file_, static_cast<off_t>(position_), SEEK_SET) == 0);
}

Result<void> StreamFile::Publish() {
  if (failure_ == 0) Keep(std::fflush(file_) == 0);
  if (failure_ != 0) return FileError("cannot write", temporary_, failure_);
  if (auto published = PublishFile(temporary_, path_); !published) return published;
  std::fclose(file_);
  file_ = nullptr;
  return {};
}

}  // namespace skyquilt::storage
