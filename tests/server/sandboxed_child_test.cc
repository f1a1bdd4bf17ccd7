// What becomes of a sandboxed process that hangs or lies. This program is such a process itself where it is
// started as one (main below).
#include "server/sandbox/sandboxed_child.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "core/base/progress.h"
#include "core/base/text/json_io.h"
#include "server/jobs/child_messages.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/preview/preview_sandboxed.h"
#include "server/sandbox/run_sandboxed.h"
#include "server/sandbox/sandbox.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/db/ids.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kSoon{8};  // sooner than the patience with whoever is still wanted

constexpr const char* kWithoutRoom = "without_room.jpg";  // for its preview the disk has no room

[[noreturn]] void HangForEver() {
  while (true) pause();
}

constexpr const char* kSecrets[] = {"SKYQUILT_TOKEN", "AWS_SECRET_ACCESS_KEY", "PGPASSWORD", "https_proxy"};

// Of the secrets, and of what a library needs, what this process was given.
std::string VariablesHere() {
  std::string given;
  for (const char* secret : kSecrets) {
    if (std::getenv(secret) != nullptr) given += std::string(secret) + " ";
  }
  const char* const proj = std::getenv("PROJ_DATA");
  return given + (proj == nullptr ? "no PROJ_DATA" : proj);
}

void ActAsPreview(MessageReader& from_parent, MessageWriter& to_parent) {
  const std::optional<std::string> text = from_parent.Read(std::chrono::hours(1));
  if (!text) return;
  const storage::StoredFile photo = ParseRequest(*text)->fresh.at(0);
  if (photo.name == kWithoutRoom) {
    to_parent.Write(ToText(PreviewMessage(PhotoBegun{photo.stored_name})));
    to_parent.Write(ToText(PreviewMessage(Error{ErrorCode::kOutOfSpace, "The disk is full."})));
    return;
  }
  while (to_parent.Write(ToText(PreviewMessage(PhotoBegun{photo.stored_name})))) {
  }
}

// What a process of that command does. The exit code.
int ActAs(std::string_view command, int parent) {
  if (command == "deaf") {
    if (!FollowParent(parent, SIGKILL)) return 1;
    HangForEver();
  }
  return WorkForParent(parent, [&](const std::string&, MessageReader& from_parent, MessageWriter& to_parent) {
    if (command == "interrupted") raise(SIGINT);
    if (command == "lingers" || command == "interrupted") to_parent.Write("{}");
    if (command == "tells") to_parent.Write(VariablesHere());
    if (command == "preview-sandboxed") ActAsPreview(from_parent, to_parent);
    if (command == "fails") {
      const nlohmann::json failure = {{"error", ErrorJson({ErrorCode::kOutOfSpace, "The disk is full."})}};
      to_parent.Write(JsonText(failure));
      return 1;
    }
    if (command == "stitch-sandboxed") {
      to_parent.Write(ToText(JobMessage(Error{ErrorCode::kOutOfSpace, "The disk is full."})));
      return 1;
    }
    HangForEver();
    return 0;
  });
}

TEST(SandboxedChild, OneThatDoesNotReadItsTaskIsWaitedForOnlyWhileItIsWanted) {
  const std::string more_than_a_pipe_holds(1 << 20, 'x');
  const Clock::time_point began = Clock::now();
  const auto go_on = [began] { return Clock::now() - began < std::chrono::milliseconds(300); };
  const auto child = test::ValueOf(SandboxedChild::Start("deaf", more_than_a_pipe_holds, go_on));
  EXPECT_LT(Clock::now() - began, kSoon);
  EXPECT_EQ(child->Kill().wait_status, SIGKILL);
}

TEST(SandboxedChild, OneThatDoesNotEndAfterItsLastWordIsWaitedForOnlyWhileItIsWanted) {
  bool is_wanted = true;
  const auto child = SandboxedChild::Start("lingers", "task", [&] { return is_wanted; });
  ASSERT_TRUE(child) << child.error().detail;
  EXPECT_EQ((*child)->Listen(std::chrono::seconds(60)), "{}");
  is_wanted = false;
  const Clock::time_point began = Clock::now();
  EXPECT_EQ((*child)->End().wait_status, SIGKILL);
  EXPECT_LT(Clock::now() - began, kSoon);
}

// Else one that reads back what it has just said would keep its parent reading.
TEST(SandboxedChild, ReadingAndWritingNeverBlock) {
  const auto pipes = [] {
    std::set<int> found;
    for (int fd = STDERR_FILENO + 1; fd < 1024; ++fd) {
      struct stat what {};
      if (fstat(fd, &what) == 0 && S_ISFIFO(what.st_mode)) found.insert(fd);
    }
    return found;
  };
  const std::set<int> before = pipes();
  const auto child = test::ValueOf(SandboxedChild::Start("lingers", "task", nullptr));
  int own = 0;
  for (const int fd : pipes()) {
    if (before.contains(fd)) continue;
    EXPECT_NE(fcntl(fd, F_GETFL) & O_NONBLOCK, 0);
    EXPECT_NE(fcntl(fd, F_GETFD) & FD_CLOEXEC, 0);
    ++own;
  }
  EXPECT_EQ(own, 2);
}

// Else an export, or the file that is decoded at that moment, failed for the Ctrl-C that stops its server.
TEST(SandboxedChild, ACtrlCInTheTerminalOfItsParentIsItsParents) {
  const auto child = test::ValueOf(SandboxedChild::Start("interrupted", "task", nullptr));
  EXPECT_EQ(child->Listen(std::chrono::seconds(60)), "{}");
}

// Whatever is taken over by a file could write them into the map that it makes.
TEST(SandboxedChild, HasNoSecretOfItsParent) {
  for (const char* secret : kSecrets) setenv(secret, "a key", 1);
  setenv("PROJ_DATA", "/opt/proj", 1);
  const auto child = SandboxedChild::Start("tells", "task", nullptr);
  for (const char* secret : kSecrets) unsetenv(secret);
  unsetenv("PROJ_DATA");
  ASSERT_TRUE(child) << child.error().detail;
  EXPECT_EQ((*child)->Listen(std::chrono::seconds(60)), "/opt/proj");
}

TEST(StitchSandboxed, AnErrorThatItToldStandsHoweverItEnds) {
  SilentProgress progress;
  const JobLimits limits{
      .wall = std::chrono::seconds(600), .cpu_s = 600, .memory_bytes = std::int64_t{1} << 40};
  const StitchedInSandbox made = StitchSandboxed({}, limits, progress);
  ASSERT_FALSE(made.outcome);
  EXPECT_EQ(made.outcome.error().code, ErrorCode::kOutOfSpace) << made.outcome.error().message;
  EXPECT_FALSE(made.has_died);
}

TEST(RunSandboxed, AnErrorThatItToldStandsHoweverItEnds) {
  const Result<std::string> answer =
      RunSandboxed({.command = "fails", .task = "task", .refusal = "The file is damaged."});
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kOutOfSpace) << answer.error().message;
}

// In a process of its own, in which nothing is begun any more afterwards.
TEST(RunSandboxed, WhatAStopEndsIsNotTheFaultOfItsFiles) {
  for (const char* command : {"deaf", "lingers"}) {
    const pid_t server = fork();
    if (server == 0) {
      std::thread([] {
        std::this_thread::sleep_for(std::chrono::seconds(1));
        EndAllSandboxed();
      }).detach();
      const Result<std::string> answer = RunSandboxed(
          {.command = command, .task = std::string(1 << 20, 'x'), .refusal = "The file is damaged."});
      _exit(!answer && answer.error().code == ErrorCode::kUnavailable ? 0 : 1);
    }
    EXPECT_EQ(WaitOrKill(server, kSoon).wait_status, 0) << command;
  }
}

class HungPreview : public testing::Test {
 protected:
  explicit HungPreview(const char* photo = "a.jpg") {
    const std::string flight = catalogue_.AddFlight("field", "{}", storage::Now())->id;
    std::filesystem::create_directories(dir_.Files(flight));
    EXPECT_TRUE(catalogue_.AddFile(flight, {photo, storage::NewId(), 5}, storage::Now()));
  }

  test::TemporaryFolder folder_;
  storage::DataDir dir_ = *storage::DataDir::Open(folder_.path() / "data");
  std::unique_ptr<storage::CatalogueDb> db_ = *storage::CatalogueDb::Open(folder_.path() / "catalogue.db");
  storage::FolderBlobs blobs_{folder_.path() / "data"};
  storage::Catalogue catalogue_{*db_};
  storage::Previews previews_{*db_};
  std::atomic<bool> is_stopping_ = false;
};

TEST_F(HungPreview, OneThatBeginsPhotosForEverHasNoTimeForEver) {
  SandboxedPreview drawing(dir_, blobs_, previews_, {}, is_stopping_);
  const Result<bool> drawn = drawing.Step();
  ASSERT_TRUE(drawn) << drawn.error().detail;
  EXPECT_FALSE(test::ValueOf(previews_.Claim(3))) << "its photo is passed over";
}

TEST_F(HungPreview, AStopEndsItAndItsPhotoWaitsAgain) {
  SandboxedPreview drawing(dir_, blobs_, previews_, {}, is_stopping_);
  is_stopping_ = true;
  const Clock::time_point began = Clock::now();
  const Result<bool> drawn = drawing.Step();
  ASSERT_TRUE(drawn) << drawn.error().detail;
  EXPECT_LT(Clock::now() - began, kSoon);
  const auto again = previews_.Claim(3);
  ASSERT_TRUE(again && *again);
  EXPECT_EQ((*again)->fresh.size(), 1u);
  EXPECT_TRUE((*again)->tried.empty());
}

class PreviewWithoutRoom : public HungPreview {
 protected:
  PreviewWithoutRoom() : HungPreview(kWithoutRoom) {}
};

TEST_F(PreviewWithoutRoom, AFullDiskIsSaidAndThePhotoWaitsAgain) {
  SandboxedPreview drawing(dir_, blobs_, previews_, {}, is_stopping_);
  const Result<bool> drawn = drawing.Step();
  ASSERT_FALSE(drawn);
  EXPECT_EQ(drawn.error().code, ErrorCode::kOutOfSpace);
  const auto again = previews_.Claim(3);
  ASSERT_TRUE(again && *again);
  EXPECT_EQ((*again)->fresh.size(), 1u);
  EXPECT_TRUE((*again)->tried.empty());
}

}  // namespace
}  // namespace skyquilt::server

// As SpawnSelf starts it: "skyquilt COMMAND --parent PROCESS".
int main(int count, char** arguments) {
  if (count == 4 && std::string_view(arguments[2]) == "--parent")
    _exit(skyquilt::server::ActAs(arguments[1], std::atoi(arguments[3])));
  signal(SIGPIPE, SIG_IGN);  // as servers and workers do
  testing::InitGoogleTest(&count, arguments);
  return RUN_ALL_TESTS();
}
