// How the cost grows with joints, recording length, population and effects, and memory with recording length.
//
//   growth [--quick] [-o DIR]        (default: out/growth)
//
// Prints tables, writes growth.json and report.html. Times are CPU times of one thread, the least of several batches,
// taken round by round over all sizes, so that a slow moment of the machine spoils no curve. An exponent is the slope
// of the least-squares line through the logarithms, over the sizes from a tenth of the largest on.
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/arm.h"
#include "bench/growth/memory.h"
#include "ga/problem.h"
#include "reports/context.h"
#include "reports/html.h"
#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/zoomable.h"
#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Settings {
  bool quick = false;
  std::string folder = "out/growth";
  double batch = 0.02;  ///< CPU seconds of a batch, at least
  int rounds = 5;
};

/// One curve: cost against size.
struct Series {
  std::string name;
  std::vector<double> size, cost;  ///< cost in s, or bytes
  std::string stopped;             ///< why there are no larger sizes

  double exponent() const {
    double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (std::size_t i = 0; i < size.size(); ++i) {
      if (size[i] < 0.1 * size.back() || !(cost[i] > 0.0)) continue;
      const double x = std::log(size[i]), y = std::log(cost[i]);
      n += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    return n > 1.0 ? (n * sxy - sx * sy) / (n * sxx - sx * sx) : std::nan("");
  }
};

struct Study {
  std::string title, size_label, cost_label;
  double cost_unit = 1.0;  ///< cost is shown divided by it
  std::vector<Series> series;
};

using Work = std::function<void()>;

double cpu_now() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// CPU seconds of one call, in a batch long enough for the clock.
double seconds_of(const Work& work, double batch) {
  for (long calls = 1;; calls *= 4) {
    const double begin = cpu_now();
    for (long k = 0; k < calls; ++k) work();
    const double spent = cpu_now() - begin;
    if (spent >= batch) return spent / static_cast<double>(calls);
  }
}

/// The least cost of every size, all sizes once a round.
void measure(Series& series, const std::vector<Work>& works, const Settings& settings) {
  series.cost.assign(works.size(), HUGE_VAL);
  for (int round = 0; round < settings.rounds; ++round)
    for (std::size_t i = 0; i < works.size(); ++i)
      series.cost[i] = std::min(series.cost[i], seconds_of(works[i], settings.batch));
}

/// Body i hangs on body i - 1 (chain) or (i - 1) / 2 (binary tree): rods of 0.2 m, axes x, y, z in turn.
std::shared_ptr<const Robot> many_joints(int count, bool chain) {
  std::vector<Joint> joints;
  std::vector<Link> links;
  for (int i = 0; i < count; ++i) {
    Joint joint;
    joint.name = fmt::format("joint_{}", i);
    joint.parent = chain ? i - 1 : (i + 1) / 2 - 1;
    joint.link = i;
    joint.origin.translation() = Eigen::Vector3d(joint.parent < 0 ? 0.0 : 0.2, 0.0, 0.0);
    joint.axis = Eigen::Vector3d::Unit(i % 3);
    joints.push_back(joint);
    Link link;
    link.name = fmt::format("link_{}", i);
    link.body = i;
    link.inertial = {0.5, {0.1, 0.0, 0.0}, Eigen::Vector3d(1e-4, 2e-3, 2e-3).asDiagonal()};
    links.push_back(link);
  }
  return std::make_shared<const Robot>(chain ? "chain" : "tree", std::move(joints), std::move(links), "growth");
}

/// One evaluation of forward dynamics, in a state that changes from call to call.
Work forward_dynamics(const Engine& engine, std::shared_ptr<const Robot> robot) {
  struct State {
    std::unique_ptr<Dynamics> dynamics;
    std::vector<double> q, v, tau, a;
    double phase = 0.0;
  };
  auto s = std::make_shared<State>();
  s->q.resize(robot->dof());
  s->v = s->tau = s->a = s->q;
  s->dynamics = engine.build(std::move(robot), {0.0, 0.0, -9.81});
  return [s] {
    s->phase = std::fmod(s->phase + 0.6180339887498949, 1.0);
    for (std::size_t j = 0; j < s->q.size(); ++j) {
      s->q[j] = std::fmod(s->phase + 0.37 * static_cast<double>(j), 1.0) - 0.5;
      s->v[j] = 0.3 - 0.6 * s->phase;
      s->tau[j] = s->phase;
    }
    s->dynamics->forward_dynamics(s->q, s->v, s->tau, s->a);
  };
}

Study growth_with_joints(const Settings& settings, bool chain) {
  Study study{fmt::format("Joints, {}", chain ? "chain" : "binary tree"), "joints", "us an evaluation", 1e-6, {}};
  const std::vector<int> counts =
      settings.quick ? std::vector<int>{2, 6, 20, 100} : std::vector<int>{2, 5, 10, 20, 50, 90, 140, 200};
  for (const Engine* engine : engines()) {
    if (!engine->info().available) continue;
    Series series{engine->info().name, {}, {}, ""};
    std::vector<Work> works;
    for (const int n : counts) {
      try {
        works.push_back(forward_dynamics(*engine, many_joints(n, chain)));
        series.size.push_back(n);
      } catch (const WorkError& error) {
        series.stopped = fmt::format("not at {} joints: {}", n, error.what());
        break;
      }
    }
    measure(series, works, settings);
    study.series.push_back(std::move(series));
  }
  return study;
}

/// The genetic algorithm's cost call on one thread.
struct Population {
  Population(double seconds, int individuals, const std::vector<EffectSpec>& effects)
      : scenario(arm_scenario(seconds)),
        model(PlantModel(scenario).with_effects(effects)),
        experiment(make_experiment(scenario)),
        space(model, scenario),
        problem(model, experiment, space, SimulatorOptions{}, first_weights(model, experiment)),
        points(static_cast<std::size_t>(individuals), space.start()),
        costs(points.size()),
        train(experiment.with_role(Role::train)) {
    for (std::size_t i = 0; i < points.size(); ++i) points[i][0] *= 0.7 + 0.3 * static_cast<double>(i) / individuals;
  }
  void run() { problem.costs(points, costs, train, Fitness::norm_2); }

  Scenario scenario;
  PlantModel model;
  Experiment experiment;
  SearchSpace space;
  Problem problem;
  std::vector<std::vector<double>> points;
  std::vector<double> costs;
  std::vector<int> train;
};

Work population_call(double seconds, int individuals, const std::vector<EffectSpec>& effects) {
  auto population = std::make_shared<Population>(seconds, individuals, effects);
  return [population] { population->run(); };
}

/// The first `count` of smooth effects on joint after joint.
std::vector<EffectSpec> effects_on_arm(int count) {
  const std::vector<std::pair<std::string, std::string>> kinds = {
      {"quadratic_damping", "c"}, {"stiffness_hardening", "k3"}, {"valve_offset", "b"}, {"damping_asymmetry", "a"}};
  const auto joints = arm_robot()->joints();
  std::vector<EffectSpec> out;
  for (int k = 0; k < count; ++k) {
    const auto& [effect, parameter] = kinds[static_cast<std::size_t>(k) / joints.size()];
    out.push_back({effect, joints[static_cast<std::size_t>(k) % joints.size()].name, {{parameter, 0.1}}, {}, "growth"});
  }
  return out;
}

Study growth_of_calls(const Settings& settings) {
  Study study{"Recording length (8 individuals), population and effects (1 s), Featherstone, six joints",
              "size",
              "ms a call",
              1e-3,
              {}};
  const double top = settings.quick ? 4.0 : 32.0;
  Series length{"recording, s", {}, {}, ""};
  std::vector<Work> works;
  for (double seconds = 1.0; seconds <= top; seconds *= 2.0) {
    length.size.push_back(seconds);
    works.push_back(population_call(seconds, 8, {}));
  }
  measure(length, works, settings);
  study.series.push_back(std::move(length));

  Series individuals{"individuals", {}, {}, ""};
  works.clear();
  for (int n = 8; n <= (settings.quick ? 32 : 512); n *= 2) {
    individuals.size.push_back(n);
    works.push_back(population_call(1.0, n, {}));
  }
  measure(individuals, works, settings);
  study.series.push_back(std::move(individuals));

  Series effects{"effects", {}, {}, ""};
  works.clear();
  for (const int n : settings.quick ? std::vector<int>{1, 6} : std::vector<int>{1, 3, 6, 12, 24}) {
    effects.size.push_back(n);
    works.push_back(population_call(1.0, 8, effects_on_arm(n)));
  }
  measure(effects, works, settings);
  study.series.push_back(std::move(effects));
  return study;
}

/// Largest memory that one cost call holds beyond what was there before it.
Study growth_of_memory(const Settings& settings) {
  Study study{"Memory of one cost call (one thread)", "recording length, s", "KiB at most", 1024.0, {}};
  for (const int n : {8, 64, 512}) {
    Series series{fmt::format("population {}", n), {}, {}, ""};
    for (double seconds = 1.0; seconds <= (settings.quick ? 2.0 : 16.0); seconds *= 2.0) {
      Population population(seconds, n, {});
      reset_peak();
      const std::size_t before = bytes_in_use();
      population.run();
      series.size.push_back(seconds);
      series.cost.push_back(static_cast<double>(peak_bytes() - before));
    }
    study.series.push_back(std::move(series));
    if (settings.quick && n == 64) break;
  }
  return study;
}

std::string table_of(const Study& study) {
  std::vector<double> sizes;
  for (const Series& s : study.series)
    for (const double x : s.size)
      if (std::find(sizes.begin(), sizes.end(), x) == sizes.end()) sizes.push_back(x);
  std::sort(sizes.begin(), sizes.end());
  std::string head = fmt::format("| {}; {} |", study.size_label, study.cost_label), rule = "|---|", out;
  for (const double x : sizes) head += fmt::format(" {} |", x), rule += "---|";
  out = fmt::format("**{}**\n\n{} exponent |\n{}---|\n", study.title, head, rule);
  std::string notes;
  for (const Series& s : study.series) {
    out += fmt::format("| {} |", s.name);
    for (const double x : sizes) {
      const auto at = std::find(s.size.begin(), s.size.end(), x);
      const std::size_t i = at - s.size.begin();
      out += at == s.size.end() ? " |" : fmt::format(" {:.3g} |", s.cost[i] / study.cost_unit);
    }
    out += fmt::format(" {:.2f} |\n", s.exponent());
    if (!s.stopped.empty()) notes += fmt::format("\n{}: {}.\n", s.name, s.stopped);
  }
  return out + notes + "\n";
}

/// Straight lines are powers: both axes are logarithms.
Html plot_of(const Study& study) {
  constexpr Ink kInks[] = {Ink::after, Ink::before, Ink::measured, Ink::other};
  std::vector<std::vector<double>> decades, shown;
  for (const Series& s : study.series) {
    std::vector<double>&x = decades.emplace_back(), &y = shown.emplace_back();
    for (const double size : s.size) x.push_back(std::log10(size));
    for (const double cost : s.cost) y.push_back(cost / study.cost_unit);
  }
  LinePlot plot;
  plot.title = study.title;
  plot.description = study.cost_label + " against " + study.size_label + ", both logarithmic";
  plot.x_label = "log10 of " + study.size_label;
  plot.y_label = study.cost_label;
  plot.log_y = true;
  plot.height = 360;
  for (std::size_t k = 0; k < study.series.size(); ++k)
    plot.curves.push_back({fmt::format("{}, exponent {:.2f}", study.series[k].name, study.series[k].exponent()),
                           decades[k], shown[k], kInks[k % 4], 2.0, false});
  return zoomable(plot);
}

Json json_of(const Study& study) {
  Json series = Json::array();
  for (const Series& s : study.series) {
    Json one{{"name", s.name}, {"size", s.size}, {"cost", s.cost}};
    one["exponent"] = std::isfinite(s.exponent()) ? Json(s.exponent()) : Json(nullptr);
    if (!s.stopped.empty()) one["stopped"] = s.stopped;
    series.push_back(one);
  }
  return {{"title", study.title},
          {"size", study.size_label},
          {"cost", study.cost_unit == 1024.0 ? "bytes" : "s"},
          {"series", series}};
}

void write(const Settings& settings, const std::vector<Study>& studies, const Context& context) {
  Json record{{"format", "lacuna-growth/1"},
              {"context",
               {{"date", context.date},
                {"cpu", context.cpu},
                {"cores", context.cores},
                {"compiler", context.compiler},
                {"flags", context.flags},
                {"commit", context.commit},
                {"lanes", context.lanes},
                {"command_line", context.command_line}}},
              {"studies", Json::array()}};
  Page page("Growth of the cost", "Lacuna benchmark");
  for (const Study& study : studies) {
    record["studies"].push_back(json_of(study));
    Html notes;
    for (const Series& s : study.series)
      if (!s.stopped.empty()) notes += paragraph(s.name + ": " + s.stopped);
    page.section(study.title, plot_of(study) + notes);
  }
  page.section("Context", context_section(context));
  const std::filesystem::path folder = settings.folder;
  write_file_atomically(folder / "growth.json", record.dump(1) + "\n");
  write_file_atomically(folder / "report.html", page.str());
}

Settings understood(int argc, char** argv) {
  Settings out;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--quick") {
      out.quick = true, out.batch = 1e-4, out.rounds = 1;
    } else if (word == "-o" && i + 1 < argc) {
      out.folder = argv[++i];
    } else {
      throw InputError("growth", quoted(word), "[--quick] [-o DIR]");
    }
  }
  return out;
}

void run(int argc, char** argv) {
  const Settings settings = understood(argc, argv);
  std::string line;
  for (int i = 0; i < argc; ++i) line += (i > 0 ? " " : "") + std::string(argv[i]);
  const Context context = make_context(1, 1, line);
  const std::vector<Study> studies{growth_with_joints(settings, true), growth_with_joints(settings, false),
                                   growth_of_calls(settings), growth_of_memory(settings)};
  write(settings, studies, context);
  std::string out =
      fmt::format("{}, {}, lanes {}, commit {}\n\n", context.date, context.cpu, context.lanes, context.commit);
  for (const Study& study : studies) out += table_of(study);
  std::cout << out << "written to " << settings.folder << ": report.html, growth.json\n";
}

}  // namespace
}  // namespace lacuna::bench

int main(int argc, char** argv) {
  try {
    lacuna::bench::run(argc, argv);
    return 0;
  } catch (const lacuna::InputError& error) {
    std::cerr << "growth: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "growth: " << error.what() << '\n';
    return 3;
  }
}
