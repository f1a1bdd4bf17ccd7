#include "storage/exports/warped/block_spool.h"

#include <cerrno>
#include <system_error>

#include "storage/files/publish_file.h"

namespace skyquilt::storage {

Result<std::unique_ptr<BlockSpool>> BlockSpool::Create(const std::filesystem::path& path) {
  std::FILE* file = std::fopen(path.c_str(), "w+be");
  if (file == nullptr) return FileError("cannot write", path, errno);
  std::error_code gone;  // else it lies there until somebody removes it
  std::filesystem::remove(path, gone);
  return std::unique_ptr<BlockSpool>(new BlockSpool(path, file));
}

BlockSpool::~BlockSpool() { std::fclose(file_); }  // whatever was to be read has been

Result<void> BlockSpool::Append(std::string_view block) {
  if (fseeko(file_, static_cast<off_t>(length_), SEEK_SET) != 0 ||
      std::fwrite(block.data(), 1, block.size(), file_) != block.size())
    return FileError("cannot write", path_, errno);
  length_ += block.size();
  return {};
}

Result<void> BlockSpool::Flush() {
  if (std::fflush(file_) != 0) return FileError("cannot write", path_, errno);
  return {};
}

Result<std::string> BlockSpool::Read(std::uint64_t offset, std::uint64_t bytes) {
  std::string block(bytes, '\0');
  errno = EIO;  // where the file ends early
  if (fseeko(file_, static_cast<off_t>(offset), SEEK_SET) != 0 ||
      std::fread(block.data(), 1, block.size(), file_) != block.size())
    return FileError("cannot read", path_, errno);
  return block;
}

}  // namespace skyquilt::storage
