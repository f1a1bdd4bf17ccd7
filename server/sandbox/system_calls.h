// The system calls that this process may still make: those needed to compute on files it may open. Sockets,
// other programs, other processes, links and changes of owner and mode are refused (EPERM); calls that only
// an attack makes (ptrace, mounts, keys, io_uring, bpf, modules) end the process by SIGSYS; all others do not
// exist (ENOSYS). Holds for all threads and is irrevocable. Error: kUnavailable.
#pragma once

#include "core/base/result.h"

namespace skyquilt::server {

Result<void> ConfineSystemCalls();

}  // namespace skyquilt::server
