// PhotoStore: the uploaded bytes. An upload streams into incoming/, is fsynced and renamed to a name of ours
// below the flight (where photos lie elsewhere: put there); the name the user gave is data and never a path.
// What was not finished is removed when the Upload goes out of scope, and by Sweep after a crash: its name
// says that it is temporary and ours. Any thread; one Upload is used by one thread at a time. Errors:
// kInvalidArgument (a name that is a path), kUnprocessable (no bytes), kTooLarge, kOutOfSpace, kIo, and those
// of the blobs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/process/file_descriptor.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

inline constexpr std::int64_t kMaxFileBytes = std::int64_t{4} << 30;

// 1 to 255 bytes of UTF-8 without slashes, backslashes, control characters; not "." or "..".
Result<void> CheckFileName(std::string_view name);
bool IsValidUtf8(std::string_view text);

// A file that is being written.
struct IncomingFile {
  explicit IncomingFile(FileDescriptor opened) : descriptor(std::move(opened)) {}
  // A new one below incoming/, which goes with this; not open: errno says why.
  explicit IncomingFile(const DataDir& dir);
  ~IncomingFile();
  // Counts in `written` what went. False: it failed, as errno says.
  bool Write(std::span<const std::uint8_t> bytes, std::int64_t& written) const;

  std::filesystem::path temporary;  // removed with this; empty where the file stays
  FileDescriptor descriptor;
};

class Upload {
 public:
  Result<void> Write(std::span<const std::uint8_t> bytes);
  std::int64_t bytes() const { return bytes_; }
  // Durable in the flight's folder; answers the stored name. The caller then tells the catalogue.
  Result<std::string> Finish();

 private:
  friend class PhotoStore;
  // `elsewhere` with a prefix for keys: where it goes instead of `folder`.
  Upload(std::unique_ptr<IncomingFile> file, std::filesystem::path folder,
         std::shared_ptr<BlobStore> elsewhere, std::string prefix);
  std::unique_ptr<IncomingFile> file_;
  std::int64_t bytes_ = 0;
  std::filesystem::path folder_;
  std::string stored_name_;
  std::shared_ptr<BlobStore> elsewhere_;
  std::string prefix_;
};

class PhotoStore {
 public:
  // `blobs`: where photos lie; absent: in the data folder.
  explicit PhotoStore(DataDir dir, std::shared_ptr<BlobStore> blobs = nullptr);

  // `declared_bytes`: 0 when unknown.
  Result<Upload> Begin(const std::string& flight_id, std::int64_t declared_bytes) const;
  // Held against the file limit and the free space of the disk.
  Result<void> CheckSpace(std::int64_t declared_bytes) const;
  // A second name for a file of ours, in the flight's folder and durable; answers the stored name.
  Result<std::string> Adopt(const std::string& flight_id, const std::filesystem::path& path) const;
  // Where the file lies in the data folder, or to where it is fetched.
  std::filesystem::path PathOf(const std::string& flight_id, const std::string& stored_name) const;
  // The file on this machine, fetched where it lies elsewhere.
  Result<LocalBlob> Fetch(const std::string& flight_id, const std::string& stored_name) const;
  // The same of several, side by side.
  Result<std::vector<LocalBlob>> FetchAll(const std::string& flight_id,
                                          const std::vector<StoredFile>& files) const;
  void Remove(const std::string& flight_id, const std::string& stored_name) const;
  // What the catalogue did not take, for `why`. One that did not answer (kUnavailable) may have taken it:
  // then the file stays, and if it is nobody's a later sweep takes it.
  void TakeBack(const std::string& flight_id, const std::string& stored_name, const Error& why) const;
  // Files and maps of a flight that the catalogue no longer knows, and what its jobs were making on this
  // machine. What cannot be removed now, because its place is away, SweepBlobs removes later.
  void RemoveFlight(const std::string& flight_id, const std::vector<std::string>& jobs = {}) const;
  const DataDir& dir() const { return dir_; }
  BlobStore& blobs() const { return *blobs_; }

 private:
  DataDir dir_;
  std::shared_ptr<BlobStore> blobs_;
};

}  // namespace skyquilt::storage
