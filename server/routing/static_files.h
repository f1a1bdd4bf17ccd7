// ServePage: the web page's own files, from one folder: index.html at "/",
// embed.html, the bare map, at "/embed/FLIGHT", and the files in it by name. Only
// file types that a page needs, never a hidden file, a link, or anything of the build (package.json,
// node_modules). Where NAME.gz lies beside NAME (the build makes it), clients that accept gzip get that.
// Answers carry the page's Content-Security-Policy, which lets pages of other sites frame the bare map alone.
// Any thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "api/http/http_message.h"

namespace skyquilt::server {

// `basemap_origins`: "https://host" that the page may load basemap tiles from, with blanks between; empty for
// none.
api::Response ServePage(const std::filesystem::path& folder, const api::Request& request,
                        const std::string& basemap_origins = "");

// The folder given, or else the one beside the binary (../share/skyquilt/web), or else the source tree's.
// Absent when none has an index.html.
std::optional<std::filesystem::path> FindPageFolder(const std::filesystem::path& given);

}  // namespace skyquilt::server
