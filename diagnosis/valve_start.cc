#include "diagnosis/valve_start.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace lacuna {
namespace {

constexpr std::size_t kFewestSizes = 3;  ///< of commands: a line with an edge has two numbers
constexpr int kEdges = 40, kFulls = 12;  ///< of the grid
constexpr double kSame = 0.02;           ///< of the largest: commands nearer than that are one
constexpr double kBeyond = 1.5;          ///< of the largest command: where a pump's limit starts that was not seen

struct Held {
  double u, v;  ///< sizes; v < 0: against the command
};

bool is_held(const Segment& s, std::size_t j) {
  const std::vector<double>& u = s.commands->value[j];
  const auto begin = u.begin() + static_cast<std::ptrdiff_t>(s.first);
  return std::all_of(begin, begin + static_cast<std::ptrdiff_t>(s.count), [&](double x) { return x == *begin; });
}

/// Mean speed over the second half of a window, when what the first commands left has faded; NaN: not measured.
double speed_of(const Segment& s, std::size_t channel) {
  const std::vector<double>& q = s.measured[channel];
  const std::size_t middle = q.size() / 2, end = q.size() - 1;
  return (q[end] - q[middle]) / (s.compared_time(end) - s.compared_time(middle));
}

std::vector<Held> held_windows(const Experiment& experiment, int joint, bool alone) {
  std::vector<Held> out;
  const auto channel = std::find_if(experiment.channels.begin(), experiment.channels.end(), [&](const Channel& c) {
    return c.kind == ChannelKind::position && c.joint == joint;
  });
  if (channel == experiment.channels.end()) return out;
  const auto c = static_cast<std::size_t>(channel - experiment.channels.begin());
  const auto j = static_cast<std::size_t>(joint);
  for (const int i : experiment.with_role(Role::train)) {
    const Segment& s = experiment.segments[static_cast<std::size_t>(i)];
    const double u = s.commands->value[j][s.first];
    if (u == 0.0 || s.measured[c].size() < 4 || !is_held(s, j)) continue;
    bool others = false;
    for (std::size_t k = 0; k < experiment.joint_names.size(); ++k)
      others = others || (k != j && !(is_held(s, k) && s.commands->value[k][s.first] == 0.0));
    const double v = speed_of(s, c);
    if ((alone && others) || !std::isfinite(v)) continue;
    out.push_back({std::fabs(u), u > 0.0 ? v : -v});
  }
  return out;
}

std::size_t sizes_of(const std::vector<Held>& held) {
  double largest = 0.0;
  for (const Held& h : held) largest = std::max(largest, h.u);
  std::set<long> sizes;
  for (const Held& h : held) sizes.insert(std::lround(h.u / (kSame * largest)));
  return sizes.size();
}

/// The gain of least absolute errors for given opening(u): the weighted median of the ratios.
double best_gain(const std::vector<Held>& held, const std::vector<double>& opening) {
  std::vector<std::pair<double, double>> ratios;
  double all = 0.0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!(opening[i] > 0.0)) continue;
    ratios.emplace_back(held[i].v / opening[i], opening[i]);
    all += opening[i];
  }
  std::sort(ratios.begin(), ratios.end());
  double sum = 0.0;
  for (const auto& [ratio, weight] : ratios)
    if ((sum += weight) >= 0.5 * all) return ratio;
  return 0.0;
}

bool is_a_flow(const CurrentModel& model, std::size_t j) {
  const int type = model.model.actuators()[j].type;
  if (type < 0) return false;
  const ActuatorInfo& info = actuator_table()[static_cast<std::size_t>(type)];
  return info.hydraulic && info.states > 0 && !info.chambers;
}

/// Puts a gain that is searched at what was read off.
void set_gain(CurrentModel& model, const std::string& joint, double gain) {
  const int parameter = model.model.find(joint + ".gain");
  const auto& axes = model.space.axes();
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (axes[a].parameter != parameter) continue;
    const double x = axes[a].at(gain);
    if (std::isfinite(x)) model.fit.point[a] = std::clamp(x, axes[a].lower, axes[a].upper);
  }
}

bool pump_is_offered(const CurrentModel& model, const Experiment& experiment) {
  return !places_of(effect_info("shared_supply"), model, experiment).empty() &&
         !places_of(effect_info("supply_pressure_sag"), model, experiment).empty();
}

void put_in(Hypothesis& set, const Experiment& experiment, const EffectSpec& spec, const std::vector<double>& own) {
  set.model = extended(set.model, experiment, spec, set.model.fit.point, own);
  set.effects.push_back(spec);
}

}  // namespace

std::optional<ValveReading> read_valve(const Experiment& experiment, int j) {
  std::vector<Held> held = held_windows(experiment, j, true);
  if (sizes_of(held) < kFewestSizes) held = held_windows(experiment, j, false);
  if (sizes_of(held) < kFewestSizes) return std::nullopt;
  double largest = 0.0;
  for (const Held& h : held) largest = std::max(largest, h.u);
  ValveReading best;
  double least = HUGE_VAL;
  std::vector<double> opening(held.size());
  for (int e = 0; e < kEdges; ++e) {
    const double edge = largest * e / kEdges;
    for (int f = kFulls; f > 0; --f) {
      const double full = (largest - edge) * f / kFulls;
      for (std::size_t i = 0; i < held.size(); ++i) opening[i] = std::min(std::max(held[i].u - edge, 0.0), full);
      const double gain = best_gain(held, opening);
      double error = 0.0;
      for (std::size_t i = 0; i < held.size(); ++i) error += std::fabs(held[i].v - gain * opening[i]);
      if (error < least) least = error, best = {gain, edge, full, f < kFulls};
    }
  }
  return best;
}

std::optional<ValvesWithPump> valves_with_pump(const Hypothesis& from, const Experiment& experiment) {
  if (!pump_is_offered(from.model, experiment)) return std::nullopt;
  ValvesWithPump out{from, {}, {}};
  EffectSpec pump{"shared_supply", "arm", {{"n", 8.0}}, {}, "shared_supply"};
  EffectSpec sag{"supply_pressure_sag", "arm", {{"n", 3.0}}, {}, "supply_pressure_sag"};
  std::vector<double> shares, flows{0.3};
  int valves = 0;
  for (std::size_t j = 0; j < experiment.joint_names.size(); ++j) {
    const std::string& joint = experiment.joint_names[j];
    shares.push_back(0.0), flows.push_back(0.0);
    if (!is_a_flow(from.model, j)) continue;
    const ValveReading read = read_valve(experiment, static_cast<int>(j)).value_or(ValveReading{});
    if (read.gain == 0.0) continue;
    ++valves;
    const double full = read.levels ? read.full : kBeyond * read.full;
    shares.back() = 1.0 / full, flows.back() = 1.0 / std::fabs(read.gain * full);
    set_gain(out.set.model, joint, read.gain);
    if (out.set.model.model.find_effect_at("valve_deadband", joint) >= 0) continue;
    put_in(out.set, experiment, {"valve_deadband", joint, {}, {}, "valve_deadband"}, {read.edge});
    out.rivals.push_back({"valve_hysteresis", joint, {}, {}, "valve_hysteresis"});
    out.rivals_own.push_back({read.edge});
  }
  if (valves < 2) return std::nullopt;
  put_in(out.set, experiment, pump, shares);
  out.rivals.push_back(sag);
  out.rivals_own.push_back(flows);
  return out;
}

}  // namespace lacuna
