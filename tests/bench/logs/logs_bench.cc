// How fast logs are read: bytes a second on synthetic logs of 64 MB, and the memory of a 2 GB file
// (--benchmark_filter=TwoGigabytes; it is written to the temporary folder and removed).
#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "tests/core/flight/logs/log_writers.h"

namespace skyquilt::flight {
namespace {

using testing::Append;
using testing::Bytes;

constexpr std::size_t kBig = std::size_t{64} << 20;

// A flight as recorded: IMU at 400 Hz, attitude at 25 Hz, GPS at 5 Hz, and much that is not read.
void WriteDataflash(testing::DataflashWriter& w, std::size_t size) {
  w.Define(1, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
  w.Define(2, "GPS", "QBBIHBcLLeffff", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw");
  w.Define(3, "ATT", "Qcccccc", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw");
  w.Define(4, "RCOU", "QHHHHHHHHHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6,C7,C8,C9,C10,C11,C12,C13,C14");
  for (int i = 0; w.bytes().size() < size; ++i) {
    const double us = i * 2500.0;
    w.Write(1, {us, 0, 0.01, 0.02, 0.03, 0.1, 0.2, -9.8});
    w.Write(4, {us, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14});
    if (i % 16 == 0) w.Write(3, {us, 0, 1, 0, 2, 0, 90});
    if (i % 80 == 0) w.Write(2, {us, 0, 3, 1000.0 * i / 400, 2300, 12, 0.8, 47.5, 8.5, 500, 8, 90, 0, 0});
  }
}

void Dataflash(benchmark::State& state) {
  testing::DataflashWriter writer;
  WriteDataflash(writer, kBig);
  for (auto _ : state) benchmark::DoNotOptimize(ParseDataflash("big.bin", writer.bytes()).ok());
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * writer.bytes().size()));
}
BENCHMARK(Dataflash)->Unit(benchmark::kMillisecond);

void Ulog(benchmark::State& state) {
  testing::UlogWriter writer;
  writer.Define("sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;");
  writer.Define("actuator_outputs:uint64_t timestamp;uint32_t noutputs;float[16] output;");
  writer.Subscribe(0, "sensor_combined");
  writer.Subscribe(1, "actuator_outputs");
  for (std::uint64_t i = 0; writer.bytes().size() < kBig; ++i) {
    Bytes imu;
    Append(imu, i * 4000);
    for (int k = 0; k < 6; ++k) Append(imu, 0.5f);
    writer.Data(0, imu);
    Bytes outputs;
    Append(outputs, i * 4000);
    Append(outputs, std::uint32_t{8});
    for (int k = 0; k < 16; ++k) Append(outputs, 1.0f);
    writer.Data(1, outputs);
  }
  for (auto _ : state) benchmark::DoNotOptimize(ParseUlog("big.ulg", writer.bytes()).ok());
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * writer.bytes().size()));
}
BENCHMARK(Ulog)->Unit(benchmark::kMillisecond);

void MavlinkTlog(benchmark::State& state) {
  testing::TlogWriter writer;
  for (std::uint32_t i = 0; writer.bytes().size() < kBig; ++i) {
    Bytes attitude;
    Append(attitude, i * 20);
    for (int k = 0; k < 6; ++k) Append(attitude, 0.5f);
    writer.Packet(1'650'000'000'000'000 + std::uint64_t{i} * 20'000, 30, 39, attitude, true);
    writer.Packet(1'650'000'000'000'000 + std::uint64_t{i} * 20'000, 36, 222, Bytes(21, 7), true);
  }
  for (auto _ : state) benchmark::DoNotOptimize(ParseMavlinkTlog("big.tlog", writer.bytes()).ok());
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * writer.bytes().size()));
}
BENCHMARK(MavlinkTlog)->Unit(benchmark::kMillisecond);

double MegabytesResident() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") {
      double kilobytes = 0.0;
      status >> kilobytes;
      return kilobytes / 1024.0;
    }
  }
  return 0.0;
}

void TwoGigabytes(benchmark::State& state) {
  // One long flight, written in pieces whose clock goes on: only the time stamps differ.
  const auto path = std::filesystem::temp_directory_path() /
                    ("skyquilt_two_gigabytes_" + std::to_string(::getpid()) + ".bin");
  {
    std::ofstream file(path, std::ios::binary);
    testing::DataflashWriter head;
    head.Define(1, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
    file.write(reinterpret_cast<const char*>(head.bytes().data()),
               static_cast<std::streamsize>(head.bytes().size()));
    Bytes piece;
    std::uint64_t us = 0;
    for (std::uint64_t written = 0; written < (std::uint64_t{2} << 30); written += piece.size()) {
      piece.clear();
      for (int i = 0; i < 200'000; ++i, us += 1000) {
        piece.insert(piece.end(), {0xA3, 0x95, 1});
        Append(piece, us);
        piece.push_back(0);
        for (int k = 0; k < 6; ++k) Append(piece, 0.5f);
      }
      file.write(reinterpret_cast<const char*>(piece.data()), static_cast<std::streamsize>(piece.size()));
    }
  }
  for (auto _ : state) {
    const auto log = ReadLog({"two_gigabytes.bin", path});
    state.counters["samples"] = log ? static_cast<double>(log->imu.size()) : -1.0;
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * std::filesystem::file_size(path)));
  state.counters["peak_rss_MB"] = MegabytesResident();
  std::filesystem::remove(path);
}
BENCHMARK(TwoGigabytes)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace skyquilt::flight

BENCHMARK_MAIN();
