#include "ga/checkpoint.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>

#include "physics/executor.h"
#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

using nlohmann::json;

constexpr const char* format_name = "lacuna-optimizer-checkpoint/1";

json exact_list(const std::vector<double>& values) {
  json list = json::array();
  for (const double value : values) list.push_back(exact_text(value));
  return list;
}

std::vector<double> from_exact_list(const json& list) {
  std::vector<double> values;
  for (const auto& text : list) values.push_back(exact_number(text.get<std::string>()));
  return values;
}

json to_json(const RunIdentity& identity) {
  json options = json::object();
  for (const auto& [name, value] : identity.options) options[name] = value;
  return {{"optimizer", identity.optimizer},
          {"options", options},
          {"problem", identity.problem},
          {"names", identity.box.names},
          {"lower bounds", exact_list(identity.box.lower)},
          {"upper bounds", exact_list(identity.box.upper)}};
}

json to_json(const Checkpoint& checkpoint) {
  json history = json::array();
  for (const auto& r : checkpoint.history) {
    history.push_back({exact_text(r.best), exact_text(r.median), exact_text(r.mean), exact_text(r.diversity),
                       r.evaluations, exact_text(r.seconds)});
  }
  return {{"best", exact_list(checkpoint.best)},   {"best_cost", exact_text(checkpoint.best_cost)},
          {"evaluations", checkpoint.evaluations}, {"history", history},
          {"population", checkpoint.population},   {"costs", exact_list(checkpoint.costs)}};
}

GenerationRecord record_from(const json& row) {
  const auto number = [&](std::size_t i) { return exact_number(row.at(i).get<std::string>()); };
  return {.best = number(0),
          .median = number(1),
          .mean = number(2),
          .diversity = number(3),
          .evaluations = row.at(4).get<long>(),
          .seconds = number(5)};
}

Checkpoint checkpoint_from(const json& state) {
  Checkpoint checkpoint{.best = from_exact_list(state.at("best")),
                        .best_cost = exact_number(state.at("best_cost").get<std::string>()),
                        .evaluations = state.at("evaluations").get<long>(),
                        .history = {},
                        .population = state.at("population").get<std::vector<Chromosome>>(),
                        .costs = from_exact_list(state.at("costs"))};
  for (const auto& row : state.at("history")) checkpoint.history.push_back(record_from(row));
  return checkpoint;
}

/// Refuses the first difference between the run in the file and the run that wants to resume.
void require_same(const std::string& file, const json& found, const json& expected) {
  for (const auto& [key, value] : expected.items()) {
    const json theirs = found.value(key, json());
    if (key != "options") {
      if (theirs == value) continue;
      throw InputError(file, "a checkpoint of another run (" + key + " " + quoted(theirs.dump()) + ")",
                       quoted(value.dump()) + "; remove the file to start anew");
    }
    for (const auto& [option, setting] : value.items()) {
      const json their_setting = theirs.value(option, json());
      if (their_setting == setting) continue;
      throw InputError(file, "a checkpoint of another run (" + option + " = " + quoted(their_setting.dump()) + ")",
                       option + " = " + quoted(setting.dump()) + "; remove the file to start anew");
    }
  }
}

}  // namespace

std::string exact_text(double value) {
  char buffer[40];
  const double size = std::abs(value);
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, size, std::chars_format::hex);
  return std::string(std::signbit(value) ? "-" : "") + (std::isfinite(value) ? "0x" : "") + std::string(buffer, end);
}

double exact_number(const std::string& text) {
  const bool negative = text.starts_with('-');
  std::string digits = negative ? text.substr(1) : text;
  if (digits.starts_with("0x")) digits.erase(0, 2);
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::hex);
  if (error != std::errc{} || end != digits.data() + digits.size()) throw std::runtime_error("a malformed number");
  return negative ? -value : value;
}

std::string checksum(const std::string& text) {
  return fmt::format("{:016x}", hash_of(std::as_bytes(std::span(text))));
}

void save_checkpoint(const std::filesystem::path& file, const RunIdentity& identity, const Checkpoint& checkpoint) {
  const json content = {{"run", to_json(identity)}, {"state", to_json(checkpoint)}};
  const json whole = {{"format", format_name}, {"checksum", checksum(content.dump())}, {"content", content}};
  write_file_atomically(file, whole.dump() + "\n", true);
}

std::optional<Checkpoint> load_checkpoint(const std::filesystem::path& file, const RunIdentity& identity) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return std::nullopt;
  const std::string where = file.string();
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) {
    throw InputError(where, "a file that cannot be read", "a checkpoint");
  }
  try {
    const json whole = json::parse(in);
    if (whole.at("format") != format_name) {
      throw InputError(where, "format " + quoted(whole.at("format").dump()), format_name);
    }
    const json& content = whole.at("content");
    if (whole.at("checksum") != checksum(content.dump())) {
      throw InputError(where, "a damaged checkpoint (checksum)", "a whole one; remove the file to start anew");
    }
    require_same(where, content.at("run"), to_json(identity));
    return checkpoint_from(content.at("state"));
  } catch (const json::exception& error) {
    throw InputError(where, "a damaged checkpoint (" + quoted(error.what()) + ")",
                     "a whole one; remove the file to start anew");
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw InputError(where, std::string("a damaged checkpoint (") + error.what() + ")",
                     "a whole one; remove the file to start anew");
  }
}

void remove_checkpoint(const std::filesystem::path& file) {
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  remove_leftovers(file);
}

}  // namespace lacuna
