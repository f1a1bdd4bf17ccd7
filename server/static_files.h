// ServePage: the web page's own files, from one folder: index.html at "/", and what lies in it by its name.
// Only kinds of files that a page needs, never a hidden one, a link, or anything of the build (package.json,
// node_modules). Where NAME.gz lies beside NAME (the build makes it), clients that take gzip get that.
// Answers carry the page's Content-Security-Policy. Any thread.
#pragma once

#include <filesystem>
#include <optional>

#include "api/http_message.h"

namespace skyquilt::server {

api::Response ServePage(const std::filesystem::path& folder, const api::Request& request);

// The folder given, or else the one beside the binary (../share/skyquilt/web), or else the source tree's.
// Absent when none has an index.html.
std::optional<std::filesystem::path> FindPageFolder(const std::filesystem::path& given);

}  // namespace skyquilt::server
