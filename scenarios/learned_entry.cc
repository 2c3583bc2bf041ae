#include "scenarios/learned_entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scenarios/error.h"
#include "scenarios/text.h"
#include "scenarios/yaml_writer.h"

namespace lacuna {
namespace {

constexpr const char* kNames = "qvut";  // in the order of the numbers that stand for them
constexpr std::array kSuffixes{"", "_2"};

struct Bounds {
  std::size_t fewest, most;
};
constexpr std::array kKnots{Bounds{4, 256}, Bounds{2, 16}};
constexpr std::size_t kMostValues = 256;

/// "q", or "elbow.q", as `over` and `of`.
void put_variable(const YamlCursor& at, const std::string& suffix, const Robot& robot,
                  std::map<std::string, double>& out) {
  const char* const expected =
      "q or v (the joint's position or speed), JOINT.q or JOINT.v, u (its command) or t (time)";
  const std::string name = at.text();
  const std::size_t dot = name.rfind('.');
  const std::string letter = dot == std::string::npos ? name : name.substr(dot + 1);
  const std::size_t over = letter.size() == 1 ? std::string(kNames).find(letter) : std::string::npos;
  if (over == std::string::npos) at.fail(expected);
  out["over" + suffix] = static_cast<double>(over);
  if (dot == std::string::npos) return;
  const auto joint = robot.find_joint(name.substr(0, dot));
  if (!joint || over > 1) at.fail(expected);
  out["of" + suffix] = *joint + 1.0;
}

/// Knots of the variable `index` from a list of them.
std::size_t put_knots(const YamlCursor& knots, std::size_t index, std::map<std::string, double>& out) {
  constexpr double kEven = 1e-6;  // of a spacing
  const Bounds bounds = kKnots.at(index);
  const std::string suffix = kSuffixes.at(index);
  const auto places = knots.items();
  if (places.size() < bounds.fewest || places.size() > bounds.most)
    knots.fail(fmt::format("{} to {} knots", bounds.fewest, bounds.most));
  const double from = places.front().number(), to = places.back().number();
  const double spacing = (to - from) / static_cast<double>(places.size() - 1);
  if (!(spacing > 0.0)) knots.fail("knots in increasing order");
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double even = from + static_cast<double>(k) * spacing;
    if (std::fabs(places[k].number() - even) > kEven * spacing) places[k].fail("knots at even distances");
  }
  out["from" + suffix] = from, out["to" + suffix] = to, out["knots" + suffix] = static_cast<double>(places.size());
  return places.size();
}

void put_values(const YamlCursor& row, std::size_t count, std::size_t first, std::map<std::string, double>& out) {
  const auto values = row.items();
  if (values.size() != count) row.fail(fmt::format("{} values, one a knot", count));
  for (std::size_t k = 0; k < count; ++k) out[fmt::format("value_{}", first + k + 1)] = values[k].number();
}

double number_of(const EffectSpec& spec, const std::string& key) {
  const auto at = spec.parameters.find(key);
  return at == spec.parameters.end() ? 0.0 : at->second;
}

/// A list of `count` numbers.
template <class At>
void put_list(YamlWriter& yaml, int count, const At& at) {
  yaml.short_list();
  for (int k = 0; k < count; ++k) yaml.value(at(k));
  yaml.end();
}

void put_knots(YamlWriter& yaml, const EffectSpec& spec, const std::string& suffix) {
  const double from = number_of(spec, "from" + suffix), to = number_of(spec, "to" + suffix);
  const int count = static_cast<int>(number_of(spec, "knots" + suffix));
  put_list(yaml, count, [&](int k) { return k + 1 == count ? to : from + k * (to - from) / (count - 1); });
}

}  // namespace

bool is_learned(const std::string& effect) {
  using Kind = EventSpec::Kind;
  return effect == to_string(Kind::effort) || effect == to_string(Kind::command) || effect == to_string(Kind::reading);
}

std::map<std::string, double> parse_curve(const YamlCursor& entry, const Robot& robot) {
  const YamlCursor over = entry.at("over"), knots = entry.at("knots"), values = entry.at("values");
  const auto variables = over.items();
  if (variables.empty() || variables.size() > kSuffixes.size()) over.fail("one variable or two, as in [q]");
  std::map<std::string, double> out;
  for (std::size_t k = 0; k < variables.size(); ++k) put_variable(variables[k], kSuffixes.at(k), robot, out);
  if (variables.size() == 1) {
    put_values(values, put_knots(knots, 0, out), 0, out);
    if (const auto period = entry.find("period")) out["period"] = period->positive_number();
    return out;
  }
  if (const auto period = entry.find("period")) period->fail("nothing: only a law of one variable repeats itself");
  const auto sides = knots.items();
  if (sides.size() != variables.size()) knots.fail("two lists of knots, one a variable");
  const std::size_t rows = put_knots(sides[0], 0, out), columns = put_knots(sides[1], 1, out);
  if (rows * columns > kMostValues) knots.fail(fmt::format("at most {} values", kMostValues));
  const auto lines = values.items();
  if (lines.size() != rows) values.fail(fmt::format("{} lists of values, one a knot of the first variable", rows));
  for (std::size_t k = 0; k < rows; ++k) put_values(lines[k], columns, k * columns, out);
  return out;
}

VariableName variable_named(const std::string& name) {
  constexpr std::array kQuantities{"position", "speed", "command", "time"};
  const std::size_t dot = name.rfind('.');
  const std::string letter = dot == std::string::npos ? name : name.substr(dot + 1);
  const std::size_t which = letter.empty() ? std::string::npos : std::string(kNames).find(letter.front());
  return {dot == std::string::npos ? "" : name.substr(0, dot), kQuantities.at(std::min<std::size_t>(which, 3))};
}

std::vector<std::string> variables_of(const EffectSpec& spec, const Robot& robot) {
  std::vector<std::string> out;
  for (const std::string suffix : kSuffixes) {
    if (!suffix.empty() && number_of(spec, "knots" + suffix) == 0.0) continue;
    const std::string letter(1, kNames[static_cast<std::size_t>(number_of(spec, "over" + suffix))]);
    const double of = number_of(spec, "of" + suffix);
    out.push_back(of > 0.0 ? robot.joints()[static_cast<std::size_t>(of) - 1].name + "." + letter : letter);
  }
  return out;
}

void put_curve(YamlWriter& yaml, const EffectSpec& spec, const Robot& robot) {
  const int rows = static_cast<int>(number_of(spec, "knots")), columns = static_cast<int>(number_of(spec, "knots_2"));
  if (rows < static_cast<int>(kKnots.front().fewest))
    throw WorkError("a learned law at " + quoted(spec.place) + " without knots cannot be written");
  const auto value = [&](int k) { return number_of(spec, fmt::format("value_{}", k + 1)); };
  yaml.key("over").short_list();
  for (const std::string& name : variables_of(spec, robot)) yaml.value(name);
  yaml.end().key("knots");
  if (columns == 0) {
    put_knots(yaml, spec, "");
    put_list(yaml.key("values"), rows, value);
    if (const double period = number_of(spec, "period"); period > 0.0) yaml.put("period", period);
    return;
  }
  yaml.short_list();
  for (const char* suffix : kSuffixes) put_knots(yaml, spec, suffix);
  yaml.end().key("values").short_list();
  for (int row = 0; row < rows; ++row) put_list(yaml, columns, [&](int k) { return value(row * columns + k); });
  yaml.end();
}

}  // namespace lacuna
