// skyquilt: one program, one subcommand a task.
#include <dlfcn.h>
#include <signal.h>

#include <cstdlib>

#include "server/commands/commands.h"

namespace {

// OpenBLAS, where a machine has it for BLAS (numpy and QGIS bring it along), begins a thread for each
// processor as it is loaded. A process with threads cannot be confined, and sums that are shared out differ
// between machines. For libraries that are loaded later and processes that are started from here the variable
// is enough.
void KeepBlasToOneThread() {
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  using SetThreads = void (*)(int);
  if (const auto set_threads =
          reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
    set_threads(1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Where whoever started this program ignores the ends of processes, so would it: how its own ended, and
  // that they did, nobody would know.
  signal(SIGCHLD, SIG_DFL);
  KeepBlasToOneThread();
  return skyquilt::server::RunCommandLine(argc, argv);
}
