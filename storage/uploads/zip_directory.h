// CountZipEntries: how many entries the directory of a zip file has; `most` + 1 where there are more.
// libarchive takes all of them into memory before it gives the first. Looks for the signatures of entries
// from where the directory may begin, so that a directory which lies about its length is counted all the
// same; 0 for what is no zip. Any thread.
#pragma once

#include <filesystem>

namespace skyquilt::storage {

int CountZipEntries(const std::filesystem::path& path, int most);

}  // namespace skyquilt::storage
