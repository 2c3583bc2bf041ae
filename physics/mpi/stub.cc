// Stands in for load.cc where lacuna is built without MPI.
#include "physics/ranks.h"

namespace lacuna {
namespace {
constexpr const char* kReason = "built without MPI: install libopenmpi-dev and openmpi-bin, then build again";
}

std::unique_ptr<Ranks> join_ranks(const StopFlag&) {
  throw WorkError(std::string("started as one of several ranks, but ") + kReason);
}

RanksInfo ranks_info() { return {"", kReason}; }

}  // namespace lacuna
