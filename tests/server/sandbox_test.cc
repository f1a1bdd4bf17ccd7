#include "server/sandbox/sandbox.h"

#include <dirent.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <thread>

#include "server/sandbox/system_calls.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

void Write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

// A data folder with two flights; a process that may read the first one's photos and write its own folder.
class SandboxTest : public testing::Test {
 protected:
  SandboxTest() {
    Write(data() / "catalogue.db", "tokens");
    Write(data() / "flights/a/files/photo", "mine");
    Write(data() / "flights/b/files/photo", "another's");
    Write(data() / "work/other/mosaic.state", "another's");
    fs::create_directories(job());
  }
  const fs::path& data() const { return dir_.path(); }
  fs::path job() const { return data() / "work/job"; }
  fs::path photo() const { return data() / "flights/a/files/photo"; }

  // How a sandboxed process ends that returns what `act` does; negative: by that signal. 99: not confined.
  int Ends(const std::function<int()>& act, bool has_landlock = true) const {
    const pid_t pid = fork();
    if (pid == 0) {
      const Result<void> confined =
          has_landlock ? Confine({{data() / "flights/a/files"}, {job()}}) : ConfineSystemCalls();
      _exit(confined ? act() : 99);
    }
    int status = 0;
    waitpid(pid, &status, 0);
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  }
  // The error number of a call that answers below zero; 0 where it succeeded.
  static int ErrorOf(long answer) { return answer < 0 ? errno : 0; }
  static int ErrorOfOpen(const fs::path& path, int flags) { return ErrorOf(open(path.c_str(), flags, 0600)); }

 private:
  test::TemporaryFolder dir_;
};

#define REQUIRE_LANDLOCK() \
  if (LandlockVersion() == 0) GTEST_SKIP() << "this kernel has no Landlock"

TEST_F(SandboxTest, TheJobsOwnFilesAreThere) {
  EXPECT_EQ(Ends([&] {
              std::string text;
              std::ifstream(photo()) >> text;
              std::ofstream(job() / "mosaic.tmp") << "tiles";
              if (text != "mine" || rename((job() / "mosaic.tmp").c_str(), (job() / "mosaic").c_str()) != 0)
                return 1;
              if (mkdir((job() / "below").c_str(), 0700) != 0) return 2;
              if (rename((job() / "mosaic").c_str(), (job() / "below/mosaic").c_str()) != 0) return 3;
              if (unlink((job() / "below/mosaic").c_str()) != 0 || rmdir((job() / "below").c_str()) != 0)
                return 4;
              if (ErrorOfOpen("/dev/null", O_WRONLY) != 0 || ErrorOfOpen("/proc/self/status", O_RDONLY) != 0)
                return 5;
              if (ErrorOfOpen("/dev/urandom", O_RDONLY) != 0) return 6;
              return 0;
            }),
            0);
}

TEST_F(SandboxTest, ThreadsMemoryAndTimeGoOn) {
  EXPECT_EQ(Ends([] {
              int sum = 0;
              std::thread([&] { sum = static_cast<int>(std::string(1 << 20, 'x').size()); }).join();
              rusage used{};
              return sum == 1 << 20 && getrusage(RUSAGE_SELF, &used) == 0 ? 0 : 1;
            }),
            0);
}

TEST_F(SandboxTest, TimeOfTheProcessorHasAnEndThatNoSignalHandlerPutsOff) {
  EXPECT_EQ(Ends([] {
              LimitThisProcess({.more_cpu_s = 1});
              signal(SIGXCPU, SIG_IGN);
              rlimit limit{};
              if (getrlimit(RLIMIT_CPU, &limit) != 0) return 1;
              return limit.rlim_cur >= 1 && limit.rlim_max > limit.rlim_cur && limit.rlim_max < 60 ? 0 : 2;
            }),
            0);
}

TEST_F(SandboxTest, WhatBelongsToOthersIsOutOfReach) {
  REQUIRE_LANDLOCK();
  for (const auto& path :
       {data() / "catalogue.db", data() / "flights/b/files/photo", data() / "work/other/mosaic.state",
        fs::path("/etc/passwd"), fs::path("/usr/bin/env")}) {
    EXPECT_EQ(Ends([&] { return ErrorOfOpen(path, O_RDONLY); }), EACCES) << path;
    EXPECT_EQ(Ends([&] { return ErrorOfOpen(path, O_RDWR); }), EACCES) << path;
  }
  // Neither by the way round, nor by looking what there is.
  EXPECT_EQ(Ends([&] { return ErrorOfOpen(job() / "../../catalogue.db", O_RDONLY); }), EACCES);
  EXPECT_EQ(
      Ends([&] { return ErrorOfOpen("/proc/self/root" + (data() / "catalogue.db").string(), O_RDONLY); }),
      EACCES);
  EXPECT_EQ(Ends([&] { return opendir((data() / "flights").c_str()) == nullptr ? errno : 0; }), EACCES);
}

TEST_F(SandboxTest, NothingIsWrittenOutside) {
  REQUIRE_LANDLOCK();
  EXPECT_EQ(Ends([&] { return ErrorOfOpen(data() / "new", O_WRONLY | O_CREAT); }), EACCES);
  EXPECT_EQ(Ends([&] { return ErrorOfOpen("/tmp/skyquilt_escaped", O_WRONLY | O_CREAT); }), EACCES);
  EXPECT_EQ(Ends([&] { return ErrorOfOpen(photo(), O_WRONLY); }), EACCES) << "uploads are read only";
  EXPECT_EQ(Ends([&] { return ErrorOf(unlink(photo().c_str())); }), EACCES);
  EXPECT_EQ(Ends([&] { return ErrorOf(mkdir((data() / "new").c_str(), 0700)); }), EACCES);
  EXPECT_NE(Ends([&] { return ErrorOf(rename(photo().c_str(), (job() / "photo").c_str())); }), 0);
  EXPECT_NE(Ends([&] { return ErrorOf(truncate((data() / "catalogue.db").c_str(), 0)); }), 0);
  EXPECT_TRUE(fs::exists(photo()));
  EXPECT_EQ(fs::file_size(data() / "catalogue.db"), 6u);
}

// Whether the kernel has Landlock or not.
class SystemCalls : public SandboxTest, public testing::WithParamInterface<bool> {
 protected:
  int EndsHere(const std::function<int()>& act) const { return Ends(act, GetParam()); }
};

TEST_P(SystemCalls, NoSockets) {
  for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK}) {
    EXPECT_EQ(EndsHere([&] { return ErrorOf(socket(family, SOCK_STREAM, 0)); }), EPERM) << family;
  }
  const int left_open = socket(AF_INET, SOCK_STREAM, 0);  // also not with one from before
  sockaddr_in nobody{};
  nobody.sin_family = AF_INET;
  const auto* address = reinterpret_cast<const sockaddr*>(&nobody);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(connect(left_open, address, sizeof(nobody))); }), EPERM);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(bind(left_open, address, sizeof(nobody))); }), EPERM);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(listen(left_open, 1)); }), EPERM);
  close(left_open);
}

TEST_P(SystemCalls, NoProgramsAndNoProcesses) {
  EXPECT_EQ(EndsHere([] { return ErrorOf(execl("/bin/true", "true", nullptr)); }), EPERM);
  EXPECT_EQ(
      EndsHere([] { return ErrorOf(syscall(SYS_execveat, AT_FDCWD, "/bin/true", nullptr, nullptr, 0)); }),
      EPERM);
  EXPECT_NE(EndsHere([] { return ErrorOf(fork()); }), 0);
  EXPECT_NE(EndsHere([] { return std::system("true") == 0 ? 0 : 1; }), 0);
  EXPECT_EQ(EndsHere([] { return ErrorOf(syscall(SYS_memfd_create, "program", 0)); }), EPERM);
}

TEST_P(SystemCalls, OtherProcessesAreLeftAlone) {
  const pid_t other = getpid();
  EXPECT_EQ(EndsHere([&] { return ErrorOf(kill(other, 0)); }), ENOSYS);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(syscall(SYS_tgkill, other, other, 0)); }), ENOSYS);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(kill(getpid(), 0)); }), 0);
  EXPECT_EQ(EndsHere([&] {
              rlimit limit{1, 1};
              return ErrorOf(prlimit(other, RLIMIT_NOFILE, &limit, nullptr));
            }),
            ENOSYS);
  EXPECT_EQ(EndsHere([] {
              std::abort();
              return 0;
            }),
            -SIGABRT)
      << "our own bugs still abort";
}

TEST_P(SystemCalls, NoLinksForOthersToFollow) {
  EXPECT_EQ(EndsHere([&] { return ErrorOf(symlink("/etc/passwd", (job() / "mosaic.tif").c_str())); }), EPERM);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(link(photo().c_str(), (job() / "photo").c_str())); }), EPERM);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(mknod((job() / "pipe").c_str(), S_IFIFO | 0600, 0)); }), EPERM);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(chmod((data() / "catalogue.db").c_str(), 0666)); }), EPERM);
  EXPECT_EQ(EndsHere([&] { return ErrorOf(truncate((data() / "catalogue.db").c_str(), 0)); }), EPERM);
}

TEST_P(SystemCalls, WhatOnlyAnAttackAsksForIsDeadly) {
  const pid_t other = getpid();
  EXPECT_EQ(EndsHere([&] { return ErrorOf(ptrace(PTRACE_ATTACH, other, nullptr, nullptr)); }), -SIGSYS);
  EXPECT_EQ(
      EndsHere([&] { return ErrorOf(syscall(SYS_process_vm_readv, other, nullptr, 0, nullptr, 0, 0)); }),
      -SIGSYS);
  for (const long call :
       {SYS_mount, SYS_keyctl, SYS_bpf, SYS_io_uring_setup, SYS_unshare, SYS_setns, SYS_perf_event_open,
        SYS_userfaultfd, SYS_pidfd_getfd, SYS_open_by_handle_at, SYS_init_module}) {
    EXPECT_EQ(EndsHere([&] { return ErrorOf(syscall(call, 0, 0, 0, 0, 0, 0)); }), -SIGSYS) << call;
  }
  EXPECT_EQ(EndsHere([] { return ErrorOf(syscall(100'000)); }), ENOSYS) << "calls of kernels to come";
}

INSTANTIATE_TEST_SUITE_P(Kernels, SystemCalls, testing::Bool(),
                         [](const auto& about) { return about.param ? "WithLandlock" : "WithoutLandlock"; });

TEST_F(SandboxTest, AProcessWithThreadsIsNotConfinedInPart) {
  const pid_t pid = fork();
  if (pid == 0) {
    std::thread([] { pause(); }).detach();
    const int before = prctl(PR_GET_SECCOMP);
    const auto confined = Confine({});
    const bool is_free = prctl(PR_GET_SECCOMP) == before;
    _exit(!confined && confined.error().code == ErrorCode::kUnavailable && is_free ? 0 : 1);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace
}  // namespace skyquilt::server
