// Where a result comes from: the block that opens every result file and closes every report.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace lacuna {

struct Context {
  std::string date;  ///< ISO 8601, UTC
  std::string host, cpu;
  int cores = 0;  ///< hardware threads
  std::string compiler, flags, build_type;
  std::string commit;  ///< of the source at configure time; "unknown" outside a repository
  std::string version;
  std::string lanes;  ///< widest instruction set of the lanes and its width: "avx512 x 8"
  std::vector<std::pair<std::string, std::string>> engine_versions;  ///< built-in engines only
  std::uint64_t seed = 1;
  int threads = 1;           ///< of each rank
  int ranks = 1;             ///< processes that shared the work
  std::string command_line;  ///< as the user gave it
};

/// The context of this process, now.
Context make_context(std::uint64_t seed, int threads, const std::string& command_line, int ranks = 1);

/// Version of the program ("0.1.0").
const char* version();

}  // namespace lacuna
