// The program itself: an STL of two million triangles to GLB on one core, its time and its memory.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

extern char** environ;

namespace {

constexpr std::uint32_t kCells = 1000;

// A waved sheet, row by row: this program must stay small, since what a child uses is told as no
// less than what its parent did.
bool write_sheet(const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  std::array<char, 84> header{"diesink bench units=mm up=z"};
  const std::uint32_t count = 2 * kCells * kCells;
  std::memcpy(header.data() + 80, &count, 4);
  out.write(header.data(), header.size());
  const auto corner = [](std::uint32_t i, std::uint32_t j) {
    const double x = 160.0 * i / kCells, y = 120.0 * j / kCells;
    return std::array{static_cast<float>(x), static_cast<float>(y),
                      static_cast<float>(10 * std::sin(x / 13) * std::cos(y / 17))};
  };
  for (std::uint32_t j = 0; j < kCells; ++j) {
    std::vector<char> row(100 * kCells, 0);
    char* at = row.data();
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::array square{corner(i, j), corner(i + 1, j), corner(i + 1, j + 1),
                              corner(i, j + 1)};
      for (const std::array<std::size_t, 3>& facet :
           {std::array<std::size_t, 3>{0, 1, 2}, std::array<std::size_t, 3>{0, 2, 3}}) {
        const float up = 1;
        std::memcpy(at + 8, &up, 4);
        for (std::size_t k = 0; k < 3; ++k) {
          std::memcpy(at + 12 + 12 * k, square[facet[k]].data(), 12);
        }
        at += 50;
      }
    }
    out.write(row.data(), static_cast<std::streamsize>(row.size()));
  }
  return out.good();
}

// `times_mesh`: the most memory the program took, as a multiple of the mesh's own.
void stl_to_glb(benchmark::State& state) {
  const std::string stem = std::string(::access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp") +
                           "/diesink-bench-" + std::to_string(::getpid());
  std::array<std::string, 7> words{
      DIESINK_PROGRAM, "convert", stem + ".stl", stem + ".glb", "--quiet", "--threads", "1"};
  if (!write_sheet(words[2])) state.SkipWithError("cannot write");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  long peak = 0;
  double processor = 0;  // seconds
  for (auto round : state) {
    pid_t child = 0;
    int status = 1;
    struct rusage used {};
    if (::posix_spawn(&child, words[0].c_str(), nullptr, nullptr, arguments.data(), environ) != 0 ||
        ::wait4(child, &status, 0, &used) != child || status != 0) {
      state.SkipWithError("diesink convert failed");
      break;
    }
    peak = std::max(peak, used.ru_maxrss);
    for (const timeval& time : {used.ru_utime, used.ru_stime}) {
      processor += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    }
  }
  ::unlink(words[2].c_str());
  ::unlink(words[3].c_str());
  const double vertices = (kCells + 1.0) * (kCells + 1.0), triangles = 2.0 * kCells * kCells;
  state.counters["processor_s"] = processor / static_cast<double>(state.iterations());
  state.counters["peak_MB"] = static_cast<double>(peak) / 1000;
  state.counters["times_mesh"] =
      static_cast<double>(peak) * 1024 / (24 * vertices + 12 * triangles);
}

BENCHMARK(stl_to_glb)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
