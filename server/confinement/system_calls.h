// Which system calls this process may still make: those that computing on files that it may open takes, no
// others. Sockets, other programs, other processes, links and changes of owner and mode are refused (EPERM);
// what only an attack asks for (ptrace, mounts, keys, io_uring, bpf, modules) ends the process by SIGSYS;
// calls that nobody here thought of do not exist (ENOSYS). Holds for all threads and is never undone. Error:
// kUnavailable.
#pragma once

#include "core/base/result.h"

namespace skyquilt::server {

Result<void> ConfineSystemCalls();

}  // namespace skyquilt::server
