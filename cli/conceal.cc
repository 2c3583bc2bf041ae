// `lacuna conceal`: a case folder whose recordings hold physics that its scenario leaves out, the truth sealed beside
// it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "backends/engine.h"
#include "cli/command.h"
#include "cli/progress.h"
#include "cli/table.h"
#include "ga/random.h"
#include "reports/json_text.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/sha256.h"
#include "scenarios/text.h"
#include "trial/conceal.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct ConcealFlags {
  std::vector<std::string> effects, recordings;
  std::string engine = "simbody", noise = "white", perturb = "0.1..0.3";
  double visibility = 0.0;
  Imperfections imperfections;
};

constexpr std::uintmax_t kMostRobotBytes = std::uintmax_t{64} << 20;
constexpr std::uintmax_t kMostRecordingBytes = std::uintmax_t{4} << 30;

/// "0.1..0.3", or one number for both ends.
void read_perturb(const std::string& text, ConcealOptions& options) {
  const std::size_t dots = text.find("..");
  const auto least = parse_number(text.substr(0, dots));
  const auto most = dots == std::string::npos ? least : parse_number(text.substr(dots + 2));
  if (!least || !most || !(*least >= 0.0 && *least <= *most && *most < 1.0))
    throw InputError("--perturb", quoted(text), "LEAST..MOST from 0 to below 1, as 0.1..0.3");
  options.perturb_least = *least;
  options.perturb_most = *most;
}

ConcealOptions understood(const Session& session, const ConcealFlags& flags) {
  ConcealOptions out;
  for (const std::string& text : flags.effects) out.effects.push_back(parse_hidden_effect(text));
  bool partial = false;
  for (HiddenEffect& effect : out.effects) {
    const int type = find_effect(effect.effect);
    if (type < 0 || !effect_table()[type].per_recording) continue;
    effect.recordings = flags.recordings;
    partial = true;
  }
  if (!flags.recordings.empty() && !partial)
    throw InputError("--recordings", "no effect that may act in some recordings only", "one, as --effect payload:arm");
  out.noise = noise_from_name(flags.noise);
  read_perturb(flags.perturb, out);
  if (flags.visibility > 0.0) out.visibility = flags.visibility;
  out.imperfections = flags.imperfections;
  out.engine = engine_named(flags.engine);
  out.threads = session.threads;
  out.seed = session.seed;
  out.stop = &stop_flag();
  return out;
}

/// One that was cut short has no scenario yet: it is made anew.
void refuse_sealed(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder / "scenario.yaml", ignored)) return;
  if (fs::exists(folder / "label.sha256", ignored) || fs::exists(folder / "label.json", ignored))
    throw InputError("--output", quoted(folder.string()) + ", which holds a sealed case", "another folder");
}

/// Each recording once; its SHA-256 by name.
Json write_recordings(const fs::path& folder, const Scenario& scenario) {
  Json hashes = Json::object();
  for (const RecordingSpec& spec : scenario.recordings) {
    if (hashes.contains(spec.file)) continue;
    make_parent_folder(folder / spec.file);
    write_csv(folder / spec.file, *spec.data);
    hashes[spec.file] = sha256(read_text_file(folder / spec.file, spec.file, "a recording", kMostRecordingBytes));
  }
  return hashes;
}

/// So that no label can be guessed from its hash by trying all of them.
std::string salt(std::uint64_t seed) {
  RandomStream stream(seed, 0, 0, 44);
  return fmt::format("{:016x}{:016x}", stream.bits64(), stream.bits64());
}

/// As `learned[]` of a diagnosis has them, so that the two can be held against each other.
void add_law(const LawRecord& law, Json& effect) {
  effect["stage"] = law.stage;
  effect["over"] = law.over;
  for (const LawRecord::Point& p : law.curve)
    effect["curve"].push_back({{"at", p.at.size() == 1 ? Json(p.at[0]) : Json(p.at)}, {"value", p.value}});
  for (const LawRecord::Event& e : law.events)
    effect["events"].push_back({{"recording", e.recording},
                                {"from", e.from},
                                {"to", e.to},
                                {"value", e.value ? Json(*e.value) : Json(nullptr)}});
}

Json conditions_of(const Imperfections& imperfections) {
  Json out = Json::object();
  const auto add = [&](const char* name, double value) {
    if (value > 0.0 && std::isfinite(value)) out[name] = value;
  };
  add("background", imperfections.background);
  add("uneven", imperfections.uneven);
  add("drift", imperfections.drift);
  add("misplaced", imperfections.misplaced);
  add("seconds", imperfections.seconds);
  if (!imperfections.alone.empty()) out["alone"] = imperfections.alone;
  return out;
}

Json label_of(const Concealment& made, const ConcealOptions& options, const std::string& name, const Json& hashes) {
  Json effects = Json::array(), truth = Json::object(), noise = Json::object();
  bool partial = false;
  for (const ConcealedEffect& effect : made.effects) {
    Json one{{"effect", effect.asked.effect}, {"location", effect.asked.place}, {"strength", effect.strength}};
    for (const auto& [parameter, value] : effect.parameters) one["parameters"][parameter] = value;
    if (!effect.asked.recordings.empty()) one["recordings"] = effect.asked.recordings;
    if (effect.law) add_law(*effect.law, one);
    if (effect.uneven)
      one["uneven"] = {{"over", effect.uneven->over_command ? "u" : "q"},
                       {"share", effect.uneven->share},
                       {"centre", effect.uneven->centre},
                       {"width", effect.uneven->width}};
    for (const auto& [file, strength] : effect.drift) one["strength_by_recording"][file] = strength;
    partial = partial || !effect.asked.recordings.empty();
    effects.push_back(one);
  }
  Json misplaced = Json::object();
  for (const EffectSpec& shift : made.misplaced)
    for (const char* axis : {"dx", "dy", "dz"}) misplaced[shift.place].push_back(shift.parameters.at(axis));
  for (const auto& [parameter, value] : made.truth) truth[parameter] = value;
  for (const auto& [channel, rms] : made.noise) noise[channel] = rms;
  return {{"format", "lacuna-label/1"},
          {"case", name},
          {"salt", salt(options.seed)},
          {"effects", effects},
          {"conditions", conditions_of(options.imperfections)},
          {"misplaced", misplaced},
          {"partial_payload", partial},
          {"raw_rms_over_noise", made.raw_rms_over_noise},
          {"left_rms_over_noise", made.left_rms_over_noise},
          {"truth", truth},
          {"noise", {{"kind", to_string(options.noise)}, {"rms", noise}}},
          {"engine", options.engine},
          {"integrator", "Dormand-Prince 5(4), step control at 1e-8"},
          {"perturb", {options.perturb_least, options.perturb_most}},
          {"seed", options.seed},
          {"recordings", hashes},
          {"version", version()}};
}

/// The scenario last: a folder is a case only once its label is sealed.
std::string write_case(const fs::path& folder, const Scenario& source, const Concealment& made,
                       const ConcealOptions& options) {
  Scenario scenario = made.scenario;
  scenario.name = file_name(fs::absolute(folder).lexically_normal().filename().string());
  const fs::path robot = resolve(source, source.robot_file);
  scenario.robot_file = file_name(robot.filename().string());
  refuse_overwriting(robot, folder / scenario.robot_file);
  for (const RecordingSpec& spec : source.recordings)
    for (const RecordingSpec& target : scenario.recordings)
      refuse_overwriting(resolve(source, spec.file), folder / target.file);
  const Json hashes = write_recordings(folder, scenario);
  write_file_atomically(folder / scenario.robot_file,
                        read_text_file(robot, source.robot_file, "a robot (URDF)", kMostRobotBytes));
  const std::string label = json_text(label_of(made, options, scenario.name, hashes));
  const std::string seal = sha256(label);
  write_file_atomically(folder / "label.sha256", seal + "  label.json\n");
  write_file_atomically(folder / "label.json", label);
  scenario.file = folder / "scenario.yaml";
  save_scenario(scenario, scenario.file);
  return seal;
}

void report(const Session& session, const fs::path& folder, const Concealment& made, const std::string& seal) {
  if (session.json) {
    // Nothing of the label: whoever diagnoses may look at this.
    const Json out{
        {"format", "lacuna-concealment/1"}, {"case", folder.string()}, {"label_sha256", seal}, {"version", version()}};
    print(json_text(out));
    return;
  }
  std::string out;
  TextTable table({"hidden effect", "where", ">strength"});
  for (const ConcealedEffect& effect : made.effects)
    table.add({effect.asked.effect, effect.asked.place, number(effect.strength)});
  if (!table.empty()) out += table.str() + "\n";
  out += fmt::format("Left by a refit of the plain model: {} of the noise ({} before it).\n",
                     number(made.left_rms_over_noise, 3), number(made.raw_rms_over_noise, 3));
  print(out + fmt::format("Case written to {}; label sealed: {}\n", folder.string(), seal));
}

void run(Session& session, const ConcealFlags& flags) {
  const ConcealOptions options = understood(session, flags);
  if (session.output.empty()) throw InputError("--output", "nothing", "-o DIR, the folder of the new case");
  const Scenario scenario = load_scenario(session.scenario_file);
  log_notes(scenario);
  const fs::path folder = session.output;
  refuse_sealed(folder);
  refuse_overwriting(scenario.file, folder / "scenario.yaml");
  Concealment made;
  {
    ProgressLine progress("moving the true machine");
    progress.update("moving the true machine", 0.0);
    made = conceal(scenario, options);
  }
  session.output_folder(scenario);  // what is refused leaves none
  report(session, folder, made, write_case(folder, scenario, made, options));
}

}  // namespace

void add_conceal(CLI::App& app, Session& session) {
  auto flags = std::make_shared<ConcealFlags>();
  CLI::App& command =
      add_scenario_command(app, session, "conceal",
                           "Makes a case with physics that its scenario leaves out: the scenario's commands, simulated "
                           "by another engine and\n"
                           "another integrator with other parameters and the effects named. The truth goes to "
                           "label.json, its SHA-256 beside it",
                           "lacuna conceal my_arm/scenario.yaml --effect coulomb_friction:joint_2:25 -o cases/a",
                           [&session, flags] { run(session, *flags); });
  command
      .add_option("--effect", flags->effects,
                  "NAME:WHERE[:VALUE or :p=VALUE,...], any number of times; none: a case in which nothing is missing.\n"
                  "VALUE is the first parameter; what is left out takes typical values. Outside the catalogue:\n" +
                      fmt::format("{}", fmt::join(outside_physics_names(), ", ")))
      ->allow_extra_args(false);
  command.add_option("--engine", flags->engine, "Engine of the true machine (default: simbody)");
  command.add_option("--noise", flags->noise, "white, coloured or quantised (default: white)");
  command.add_option("--perturb", flags->perturb,
                     "Share by which each free parameter is moved, LEAST..MOST (default: 0.1..0.3)");
  command
      .add_option("--visibility", flags->visibility,
                  "Sets strengths so that each effect alone leaves this many times the noise after a plain refit (of\n"
                  "springs and gaps: after one in which the joint may also have the inertia behind them)")
      ->check(CLI::Range(1e-3, 1e4));
  Imperfections& other = flags->imperfections;
  command
      .add_option("--background", other.background,
                  "A ripple and a slow push at every joint that no effect describes: together they leave this many\n"
                  "times the noise after a plain refit")
      ->check(CLI::Range(1e-3, 1e4));
  command
      .add_option(
          "--uneven", other.uneven,
          "Share, at most, by which the strength of each law hidden at a joint changes along its travel, or with\n"
          "the command (contacts, delays and transducers are left even)")
      ->check(CLI::Range(1e-3, 0.99));
  command
      .add_option("--drift", other.drift,
                  "Share, at most, by which the strength of each effect hidden at a joint differs between recordings\n"
                  "(contacts excepted)")
      ->check(CLI::Range(1e-3, 0.99));
  command
      .add_option("--misplaced", other.misplaced,
                  "Metres, at most, by which each link's centre of mass lies off the robot file's, along each axis")
      ->check(CLI::Range(1e-6, 10.0));
  command.add_option("--seconds", other.seconds, "Recordings of so many seconds at most, from their start")
      ->check(CLI::Range(1e-3, 1e9));
  command.add_option("--alone", other.alone,
                     "The one joint that is commanded: the others' commands stay at their first values");
  command.add_option("--recordings", flags->recordings, "Recordings in which a payload is carried (default: all)")
      ->delimiter(',');
}

}  // namespace lacuna
