#include "reports/context.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <fstream>
#include <thread>

#include "backends/engine.h"
#include "physics/simulator.h"

// Given by the build for this file alone (cmake/library.cmake).
#ifndef LACUNA_VERSION
#define LACUNA_VERSION "unknown"
#define LACUNA_COMPILER "unknown"
#define LACUNA_FLAGS "unknown"
#define LACUNA_BUILD_TYPE "unknown"
#define LACUNA_COMMIT "unknown"
#endif

namespace lacuna {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

const char* version() { return LACUNA_VERSION; }

Context make_context(std::uint64_t seed, int threads, const std::string& command_line, int ranks) {
  Context context;
  context.date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  context.host = host_name();
  context.cpu = cpu_name();
  context.cores = static_cast<int>(std::thread::hardware_concurrency());
  context.compiler = LACUNA_COMPILER;
  context.flags = LACUNA_FLAGS;
  context.build_type = LACUNA_BUILD_TYPE;
  context.commit = LACUNA_COMMIT;
  context.version = LACUNA_VERSION;
  const LaneInfo lanes = lane_info();
  context.lanes = fmt::format("{} x {}", lanes.name, lanes.width);
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    if (info.available) context.engine_versions.emplace_back(info.name, info.version);
  }
  context.seed = seed;
  context.threads = threads;
  context.ranks = ranks;
  context.command_line = command_line;
  return context;
}

}  // namespace lacuna
