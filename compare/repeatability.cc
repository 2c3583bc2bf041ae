#include "compare/repeatability.h"

#include <algorithm>
#include <cstring>

#include "compare/runner.h"

namespace lacuna {
namespace {

/// Bit by bit: NaN equals itself, 0 differs from -0.
bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// Samples of `a` from `offset` on against all of `b`.
bool same_states(const Trajectory& a, std::size_t offset, const Trajectory& b) {
  if (a.q.size() != offset + b.q.size()) return false;
  for (std::size_t k = 0; k < b.q.size(); ++k) {
    if (!same_bits(a.q[offset + k], b.q[k]) || !same_bits(a.v[offset + k], b.v[k])) return false;
  }
  return true;
}

/// What is left of the motion after sample `at`, from the state saved there.
Motion rest_of(const Motion& motion, const Trajectory& run, std::size_t at) {
  Motion rest = motion;
  Segment& segment = rest.phases.front().segment;
  segment.first += at;
  segment.count -= at;
  segment.q0 = run.q[at];
  segment.v0 = run.v[at];
  return rest;
}

}  // namespace

void measure_repeatability(const std::string& engine, const Motion& motion, double step, MethodResult& out) {
  const Method method{out.name, out.native};
  Runner runner(engine, motion);
  const Trajectory first = runner.run(method, step), again = runner.run(method, step);
  out.repeats = same_states(first, 0, again);
  const std::size_t middle = first.q.size() / 2;
  const Motion rest = rest_of(motion, first, middle);
  out.restores = same_states(first, middle, Runner(engine, rest).run(method, step));
}

}  // namespace lacuna
