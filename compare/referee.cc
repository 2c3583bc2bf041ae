#include "compare/referee.h"

#include <algorithm>
#include <cmath>

#include "physics/cpu_clock.h"
#include "physics/effects/table.h"

namespace lacuna {
namespace {

constexpr double kLoose = 1e-13, kTight = 1e-15;              // tolerance of a step, rad and rad/s (m, m/s)
constexpr double kLooseMemory = 2.5e-4, kTightMemory = 1e-4;  // s
constexpr double kRunaway = 10.0;                             // times the reference's fastest joint

bool has_memories(const PlantModel& model) {
  return std::any_of(model.effects().begin(), model.effects().end(),
                     [](const Component& c) { return Effects::hooks<double>()[c.type].memories > 0; });
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t j = 0; j < a.size(); ++j) {
    worst = worse(worst, std::fabs(a[j] - b[j]));
  }
  return worst;
}

}  // namespace

Referee make_referee(const Motion& motion, int threads, const StopFlag* stop) {
  Referee out;
  Trajectory loose;
  double seconds[2] = {0.0, 0.0};
  parallel_for(std::min(threads, 2), 2, [&](int, int which) {
    (which == 0 ? out.reference : loose) =
        run_referee(motion, which == 0 ? kTight : kLoose, which == 0 ? kTightMemory : kLooseMemory, stop);
    seconds[which] = (which == 0 ? out.reference : loose).seconds;
  });
  out.times = motion.times();
  const bool memories = has_memories(motion.model);
  const double trusted = memories ? kTrustedWithMemories : kTrusted;
  double worst = 0.0;
  for (; out.trusted < out.times.size(); ++out.trusted) {
    const double apart = distance(out.reference.q[out.trusted], loose.q[out.trusted]);
    if (!(apart < trusted)) break;
    worst = std::max(worst, apart);
  }
  for (const std::vector<double>& v : out.reference.v)
    for (const double speed : v) out.top_speed = std::max(out.top_speed, std::fabs(speed));
  out.record.method =
      "Featherstone's equations in extended precision (64-bit mantissa), Fehlberg's pair of orders 8 and 7 with step "
      "control (Boost.odeint)";
  if (memories) out.record.method += "; memories of effects by steps of 0.1 ms";
  out.record.tolerance = kTight;
  out.record.error = worst;
  out.record.trusted_until = out.times[std::max<std::size_t>(out.trusted, 1) - 1];
  out.record.seconds = seconds[0] + seconds[1];
  return out;
}

ErrorSeries error_of(const Trajectory& run, const Referee& referee) {
  ErrorSeries out;
  const std::size_t n = std::min(referee.trusted, run.q.size());
  double sum = 0.0;
  out.stable = true;
  for (std::size_t k = 0; k < run.q.size(); ++k) {
    double worst = 0.0;
    for (std::size_t j = 0; j < run.q[k].size(); ++j) {
      const double off = std::fabs(run.q[k][j] - referee.reference.q[k][j]);
      out.stable = out.stable && std::isfinite(off) && std::fabs(run.v[k][j]) <= kRunaway * referee.top_speed + 1e-9;
      if (k >= n) continue;
      if (!(off <= out.worst)) {
        out.worst = std::isfinite(off) ? off : HUGE_VAL;
        out.worst_time = referee.times[k];
        out.worst_joint = static_cast<int>(j);
      }
      worst = worse(worst, off);
      sum += off * off;
    }
    if (k < n) out.error.push_back(worst);
  }
  if (n > 0) out.rms = std::sqrt(sum / static_cast<double>(n * run.q.front().size()));
  return out;
}

}  // namespace lacuna
