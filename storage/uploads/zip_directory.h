// CountZipEntries: how many entries the directory of a zip file has; `most` + 1 where there are more.
// libarchive takes all of them into memory before it gives the first. Looks for the signatures of entries
// from where the directory may begin, so that a directory which lies about its length is counted all the
// same; 0 for what is no zip.
//
// HasZipNameWithNul: whether a name, in the directory or before the file itself, has a NUL. libarchive ends
// names there and does not tell, so that "a.jpg\0.exe" would come in as a.jpg. False for what is no zip. Both
// read the directory alone; any thread.
#pragma once

#include <filesystem>

namespace skyquilt::storage {

int CountZipEntries(const std::filesystem::path& path, int most);
bool HasZipNameWithNul(const std::filesystem::path& path);

}  // namespace skyquilt::storage
