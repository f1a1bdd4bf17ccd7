#include "server/terminal/work_beside.h"

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "server/terminal/fail.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {

namespace fs = std::filesystem;

void CheckOutFile(const char* program, const fs::path& out, bool may_replace) {
  const auto refuse = [&](const std::string& why) { Fail(program, {ErrorCode::kInvalidArgument, why, ""}); };
  std::error_code error;
  if (fs::is_directory(out, error)) refuse(out.string() + " is a folder; name a file in it.");
  if (fs::exists(out, error) && !may_replace)
    refuse(out.string() + " is there already. Choose another name, or say --overwrite.");
  if (!fs::is_directory(out.parent_path(), error))
    refuse("The folder " + out.parent_path().string() + " is not there. Make it first.");
}

WorkBeside::WorkBeside(const char* program, const fs::path& out)
    : folder_(out.parent_path() / ("." + out.filename().string() + "-" + std::to_string(getpid()))) {
  std::error_code error;
  if (!fs::create_directory(path(), error))
    Fail(program, storage::FileError("cannot make", path(), error ? error.value() : EEXIST));
}

}  // namespace skyquilt::server
