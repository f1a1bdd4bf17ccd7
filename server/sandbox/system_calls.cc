#include "server/sandbox/system_calls.h"

#include <asm/ioctls.h>
#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace skyquilt::server {
namespace {

// Open files, and files and folders by name: which names, Landlock says.
constexpr const char* kFiles[] = {
    "read",       "readv",     "pread64",    "preadv",    "preadv2",    "write",           "writev",
    "pwrite64",   "pwritev",   "pwritev2",   "lseek",     "_llseek",    "close",           "close_range",
    "dup",        "dup2",      "dup3",       "open",      "openat",     "fstat",           "fstat64",
    "stat",       "lstat",     "newfstatat", "fstatat64", "statx",      "statfs",          "fstatfs",
    "access",     "faccessat", "faccessat2", "readlink",  "readlinkat", "getcwd",          "getdents",
    "getdents64", "mkdir",     "mkdirat",    "rmdir",     "unlink",     "unlinkat",        "rename",
    "renameat",   "renameat2", "ftruncate",  "fallocate", "fsync",      "fdatasync",       "sync_file_range",
    "fadvise64",  "flock",     "fchmod",     "fchown",    "umask",      "copy_file_range", "sendfile",
    "pipe",       "pipe2",     "poll",       "ppoll",     "select",     "pselect6"};
constexpr const char* kMemoryThreadsAndTime[] = {"mmap",
                                                 "mmap2",
                                                 "munmap",
                                                 "mprotect",
                                                 "mremap",
                                                 "madvise",
                                                 "brk",
                                                 "msync",
                                                 "mincore",
                                                 "membarrier",
                                                 "get_mempolicy",
                                                 "set_mempolicy",
                                                 "futex",
                                                 "futex_waitv",
                                                 "set_robust_list",
                                                 "get_robust_list",
                                                 "rseq",
                                                 "set_tid_address",
                                                 "gettid",
                                                 "getpid",
                                                 "getppid",
                                                 "getuid",
                                                 "geteuid",
                                                 "getgid",
                                                 "getegid",
                                                 "sched_yield",
                                                 "sched_getaffinity",
                                                 "sched_setaffinity",
                                                 "sched_getparam",
                                                 "sched_getscheduler",
                                                 "getpriority",
                                                 "getcpu",
                                                 "clock_gettime",
                                                 "clock_getres",
                                                 "clock_nanosleep",
                                                 "nanosleep",
                                                 "gettimeofday",
                                                 "time",
                                                 "times",
                                                 "rt_sigaction",
                                                 "rt_sigprocmask",
                                                 "rt_sigreturn",
                                                 "sigaltstack",
                                                 "restart_syscall",
                                                 "exit",
                                                 "exit_group",
                                                 "getrandom",
                                                 "getrusage",
                                                 "getrlimit",
                                                 "setrlimit",
                                                 "sysinfo",
                                                 "uname",
                                                 "arch_prctl"};
// Libraries ask for these now and then (nscd, git, temporary links) and go on without.
constexpr const char* kRefused[] = {"socket",       "socketpair",  "connect",
                                    "bind",         "listen",      "accept",
                                    "accept4",      "sendto",      "sendmsg",
                                    "sendmmsg",     "recvfrom",    "recvmsg",
                                    "recvmmsg",     "shutdown",    "getsockopt",
                                    "setsockopt",   "getsockname", "getpeername",
                                    "execve",       "execveat",    "fork",
                                    "vfork",        "link",        "linkat",
                                    "symlink",      "symlinkat",   "mknod",
                                    "mknodat",      "chmod",       "fchmodat",
                                    "chown",        "lchown",      "fchownat",
                                    "setxattr",     "lsetxattr",   "fsetxattr",
                                    "removexattr",  "truncate",    "utimensat",
                                    "utime",        "utimes",      "chroot",
                                    "setuid",       "setgid",      "setresuid",
                                    "setresgid",    "setgroups",   "setpriority",
                                    "memfd_create", "pidfd_open",  "pidfd_send_signal"};
constexpr const char* kDeadly[] = {"ptrace",
                                   "process_vm_readv",
                                   "process_vm_writev",
                                   "process_madvise",
                                   "pidfd_getfd",
                                   "kcmp",
                                   "mount",
                                   "umount2",
                                   "pivot_root",
                                   "mount_setattr",
                                   "move_mount",
                                   "open_tree",
                                   "fsopen",
                                   "fsconfig",
                                   "fsmount",
                                   "fspick",
                                   "setns",
                                   "unshare",
                                   "keyctl",
                                   "add_key",
                                   "request_key",
                                   "bpf",
                                   "perf_event_open",
                                   "userfaultfd",
                                   "io_uring_setup",
                                   "io_uring_enter",
                                   "io_uring_register",
                                   "init_module",
                                   "finit_module",
                                   "delete_module",
                                   "kexec_load",
                                   "kexec_file_load",
                                   "reboot",
                                   "swapon",
                                   "swapoff",
                                   "iopl",
                                   "ioperm",
                                   "open_by_handle_at",
                                   "settimeofday",
                                   "clock_settime",
                                   "adjtimex",
                                   "acct",
                                   "quotactl"};
constexpr int kFileCommands[] = {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD,  F_SETFD,     F_GETFL,     F_SETFL,
                                 F_GETLK, F_SETLK,         F_SETLKW, F_OFD_GETLK, F_OFD_SETLK, F_OFD_SETLKW};
constexpr unsigned int kDeviceRequests[] = {TCGETS, TIOCGWINSZ, FIONREAD};
constexpr int kOwnName[] = {PR_SET_NAME, PR_GET_NAME, 0x53564d41 /* PR_SET_VMA: names of memory */};

class Filter {
 public:
  Filter() : context_(seccomp_init(SCMP_ACT_ERRNO(ENOSYS))) {}
  ~Filter() {
    if (context_ != nullptr) seccomp_release(context_);
  }
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;
  bool is_made() const { return context_ != nullptr; }

  template <std::size_t kNames>
  void Add(std::uint32_t action, const char* const (&names)[kNames]) {
    for (const char* name : names) Add(action, name);
  }
  // Not every machine has every call (open is openat on ARM); what it lacks nobody can make.
  void Add(std::uint32_t action, const char* name) {
    const int number = seccomp_syscall_resolve_name(name);
    if (number < 0) return;
    Note(seccomp_rule_add(context_, action, number, 0), name);
  }
  void Allow(const char* name, const scmp_arg_cmp& where) {
    const int number = seccomp_syscall_resolve_name(name);
    if (number < 0) return;
    Note(seccomp_rule_add_array(context_, SCMP_ACT_ALLOW, number, 1, &where), name);
  }
  void Set(scmp_filter_attr attribute, std::uint32_t value) {
    Note(seccomp_attr_set(context_, attribute, value), "attribute");
  }
  void Load() { Note(seccomp_load(context_), "load"); }
  // The first thing that failed; empty.
  const std::string& failure() const { return failure_; }

 private:
  void Note(int code, const char* what) {
    if (code != 0 && failure_.empty()) failure_ = std::string(what) + ": " + std::strerror(-code);
  }
  scmp_filter_ctx context_;
  std::string failure_;
};

}  // namespace

Result<void> ConfineSystemCalls() {
  Filter filter;
  const auto refused = [](std::string why) {
    return Error{ErrorCode::kUnavailable, "The server could not confine a process to harmless system calls.",
                 "seccomp: " + std::move(why)};
  };
  if (!filter.is_made()) return refused("no memory");
  filter.Set(SCMP_FLTATR_CTL_NNP, 1);
  filter.Set(SCMP_FLTATR_CTL_TSYNC, 1);
  filter.Set(SCMP_FLTATR_CTL_OPTIMIZE, 2);  // a tree: reads and writes are many
  filter.Set(SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
  filter.Add(SCMP_ACT_ALLOW, kFiles);
  filter.Add(SCMP_ACT_ALLOW, kMemoryThreadsAndTime);
  filter.Add(SCMP_ACT_ERRNO(EPERM), kRefused);
  filter.Add(SCMP_ACT_KILL_PROCESS, kDeadly);
  // Threads, but no processes. clone3 hides its flags in memory: without it the C library takes clone.
  filter.Allow("clone", SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD));
  // abort() and the like, of this process alone.
  const auto self = static_cast<scmp_datum_t>(getpid());
  filter.Allow("kill", SCMP_A0(SCMP_CMP_EQ, self));
  filter.Allow("tgkill", SCMP_A0(SCMP_CMP_EQ, self));
  filter.Allow("prlimit64", SCMP_A0(SCMP_CMP_EQ, 0));
  filter.Allow("prlimit64", SCMP_A0(SCMP_CMP_EQ, self));
  for (const int command : kFileCommands) {
    for (const char* name : {"fcntl", "fcntl64"})
      filter.Allow(name, SCMP_A1_32(SCMP_CMP_EQ, static_cast<std::uint32_t>(command)));
  }
  for (const unsigned int request : kDeviceRequests) filter.Allow("ioctl", SCMP_A1_32(SCMP_CMP_EQ, request));
  for (const int option : kOwnName)
    filter.Allow("prctl", SCMP_A0_32(SCMP_CMP_EQ, static_cast<std::uint32_t>(option)));
  if (filter.failure().empty()) filter.Load();
  if (!filter.failure().empty()) return refused(filter.failure());
  return {};
}

}  // namespace skyquilt::server
