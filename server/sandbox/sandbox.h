// Confine: from now on this process may read the files it was given and what the system's libraries need
// (shared objects, PROJ's and GDAL's data), write below the folders it was given, and compute; no sockets, no
// other programs or processes. Irrevocable. For processes that decode files of users: called before the first
// byte of theirs is read and before a second thread is started. Landlock restricts files where the kernel has
// it (server/sandbox/landlock.h), seccomp the system calls everywhere
// (server/sandbox/system_calls.h). Error: kUnavailable; the process must then end.
#pragma once

#include <string>

#include "core/base/result.h"
#include "server/sandbox/landlock.h"

namespace skyquilt::server {

Result<void> Confine(FileAccess access);

// For people and logs: "seccomp and Landlock 7", or that the latter is missing.
std::string ConfinementHere();

}  // namespace skyquilt::server
