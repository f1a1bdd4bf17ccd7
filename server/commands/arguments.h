// What several commands take on their lines, and do with it. What is checked here ends the command with a
// message that names what was given (Fail) where it cannot be used. Main thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/scoped_folder.h"
#include "core/geo/boundary.h"
#include "core/geo/lat_lon.h"
#include "server/client/upload_flight.h"

namespace skyquilt::server {

// "46.80,7.10" of an option as a place.
geo::LatLon ParseLatLon(const char* command, const char* option, const std::string& text);

// The area that a map or an export is cut to, from a file.
geo::Boundary ReadBoundary(const char* command, const std::filesystem::path& file);

// The address of a running server; slashes at its end go.
void CheckServerAddress(const char* command, std::string& url);

// What is made of a file or folder is called by its name, as far as a flight may have it.
std::string NameOfInput(const std::filesystem::path& input);

// Sends a flight, with its progress on the terminal. Where that ends half-way, it says how to go on.
UploadedFlight UploadAtTerminal(const char* command, const std::vector<flight::InputFile>& files,
                                const UploadOptions& options);

// A file to be written: not a folder, in a folder that is there, and not there already unless it may be
// replaced.
void CheckOutFile(const char* command, const std::filesystem::path& out, bool may_replace);

// On the same disk as a file that is made, under a hidden name of this process.
std::filesystem::path HiddenBeside(const std::filesystem::path& out);

// A folder for what is put down while something is made; gone at the end.
class WorkFolder {
 public:
  WorkFolder(const char* command, const std::filesystem::path& path);
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  ScopedFolder folder_;
};

}  // namespace skyquilt::server
