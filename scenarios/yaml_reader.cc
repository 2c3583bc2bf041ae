#include "scenarios/yaml_reader.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

std::string at_line(const std::string& file, int line) { return fmt::format("{}:{}", printable(file), line); }

/// Builds the tree from yaml-cpp's events: no recursion, no shared nodes, every refusal with its line.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string file) : file_(std::move(file)) {}

  YamlNode take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    add(make(YamlNode::Kind::null, mark));
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw InputError(at_line(file_, mark.line + 1), "an alias (*)", "the value written out");
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_anchor(mark, anchor);
    if (tag != "?" && tag != "!" && !tag.empty()) refuse_tag(mark, tag);
    YamlNode node = make(YamlNode::Kind::scalar, mark);
    node.text = value;
    node.quoted = tag == "!";
    // yaml-cpp hands `~` and `null` over as plain scalars.
    if (!node.quoted && (value == "~" || value == "null" || value == "Null" || value == "NULL" || value.empty()))
      node.kind = YamlNode::Kind::null;
    add(std::move(node));
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::list, mark, tag, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::map, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Level {
    YamlNode node;
    bool has_key = false;
    std::set<std::string> known;  ///< keys so far
  };

  static YamlNode make(YamlNode::Kind kind, const YAML::Mark& mark) {
    YamlNode node;
    node.kind = kind;
    node.line = mark.line + 1;
    return node;
  }

  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != YAML::NullAnchor)
      throw InputError(at_line(file_, mark.line + 1), "an anchor (&)", "the value written out");
  }
  [[noreturn]] void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    throw InputError(at_line(file_, mark.line + 1), "the tag " + quoted(tag), "a plain value");
  }

  void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    refuse_anchor(mark, anchor);
    if (tag != "?" && !tag.empty()) refuse_tag(mark, tag);
    if (static_cast<int>(levels_.size()) >= kYamlMaxDepth)
      throw InputError(at_line(file_, mark.line + 1), fmt::format("more than {} levels of nesting", kYamlMaxDepth),
                       "a scenario");
    if (!levels_.empty() && levels_.back().node.kind == YamlNode::Kind::map && !levels_.back().has_key)
      throw InputError(at_line(file_, mark.line + 1), "a list or map as a key", "a name");
    levels_.push_back({make(kind, mark), false, {}});
  }

  void close() {
    YamlNode node = std::move(levels_.back().node);
    levels_.pop_back();
    add(std::move(node));
  }

  void add(YamlNode node) {
    if (levels_.empty()) {
      root_ = std::move(node);
      return;
    }
    Level& level = levels_.back();
    if (level.node.kind == YamlNode::Kind::list) {
      level.node.items.push_back(std::move(node));
    } else if (!level.has_key) {
      take_key(level, node);
    } else {
      level.node.items.push_back(std::move(node));
      level.has_key = false;
    }
  }

  void take_key(Level& level, const YamlNode& node) {
    if (node.kind != YamlNode::Kind::scalar || node.text.empty())
      throw InputError(at_line(file_, node.line), "an empty key", "a name");
    if (!level.known.insert(node.text).second)
      throw InputError(at_line(file_, node.line), "the key " + quoted(node.text) + " a second time", "each key once");
    level.node.keys.push_back(node.text);
    level.has_key = true;
  }

  std::string file_;
  std::vector<Level> levels_;
  YamlNode root_;
};

std::string describe(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::null: return "nothing";
    case YamlNode::Kind::list: return fmt::format("a list of {}", node.items.size());
    case YamlNode::Kind::map: return fmt::format("a map of {}", node.keys.size());
    case YamlNode::Kind::scalar: break;
  }
  return (node.quoted ? "the quoted text " : "") + quoted(node.text);
}

/// A step of a path: keys that are no plain words are quoted, so that the line stays readable.
std::string step_text(const std::string& key) {
  const bool word = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == '/';
  });
  return word ? printable(key, 80) : quoted(key);
}

}  // namespace

YamlNode parse_yaml(const std::string& text, const std::string& file) {
  const std::size_t invalid = find_invalid_utf8(text);
  if (invalid != std::string::npos) {
    const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(invalid), '\n') + 1;
    throw InputError(at_line(file, static_cast<int>(line)),
                     fmt::format("the byte 0x{:02x}", static_cast<unsigned char>(text[invalid])), "UTF-8 text");
  }
  if (text.size() > kYamlMaxBytes)
    throw InputError(printable(file), fmt::format("{} bytes", text.size()), fmt::format("at most {}", kYamlMaxBytes));
  std::istringstream stream(text);
  TreeBuilder builder(file);
  try {
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) throw InputError(printable(file), "no content", "a scenario");
    YamlNode root = builder.take();
    if (parser.HandleNextDocument(builder)) throw InputError(printable(file), "a second document", "one document");
    return root;
  } catch (const YAML::Exception& error) {
    throw InputError(at_line(file, std::max(error.mark.line, 0) + 1), "broken YAML (" + printable(error.msg) + ")",
                     "a well-formed YAML file");
  }
}

std::string YamlCursor::where() const { return at_line(file_, node_->line) + (path_.empty() ? "" : ": " + path_); }

void YamlCursor::fail(const std::string& expected) const { throw InputError(where(), describe(*node_), expected); }

YamlCursor YamlCursor::child(const YamlNode& node, const std::string& step) const {
  YamlCursor cursor(node, file_);
  cursor.path_ = path_.empty() || step.front() == '[' ? path_ + step : path_ + "." + step;
  return cursor;
}

void YamlCursor::expect_keys(const std::vector<std::string>& keys) const {
  if (!is_map()) fail("a map with the keys " + one_of(keys));
  for (const auto& [name, cursor] : entries())
    if (std::find(keys.begin(), keys.end(), name) == keys.end())
      throw InputError(cursor.where(), "the unknown key " + quoted(name), one_of(keys));
}

std::optional<YamlCursor> YamlCursor::find(const std::string& key) const {
  const auto at = std::find(node_->keys.begin(), node_->keys.end(), key);
  if (at == node_->keys.end()) return std::nullopt;
  return child(node_->items[at - node_->keys.begin()], step_text(key));
}

YamlCursor YamlCursor::at(const std::string& key) const {
  if (!is_map()) fail("a map with the key " + key);
  if (auto found = find(key)) return *found;
  throw InputError(where(), "no key " + quoted(key), "it to be given");
}

std::vector<std::pair<std::string, YamlCursor>> YamlCursor::entries() const {
  if (!is_map()) fail("a map");
  std::vector<std::pair<std::string, YamlCursor>> out;
  for (std::size_t i = 0; i < node_->keys.size(); ++i)
    out.emplace_back(node_->keys[i], child(node_->items[i], step_text(node_->keys[i])));
  return out;
}

std::vector<YamlCursor> YamlCursor::items() const {
  if (!is_list()) fail("a list");
  std::vector<YamlCursor> out;
  for (std::size_t i = 0; i < node_->items.size(); ++i) out.push_back(child(node_->items[i], fmt::format("[{}]", i)));
  return out;
}

std::string YamlCursor::text() const {
  if (!is_scalar() || node_->text.empty()) fail("a text");
  return node_->text;
}

double YamlCursor::number() const {
  if (!is_scalar() || node_->quoted) fail("a number");
  const auto value = parse_number(node_->text);
  static const std::vector<std::string> kYamlInfinities{".inf", "-.inf", "+.inf", ".Inf", "-.Inf", ".nan", ".NaN"};
  const bool infinite =
      value ? !std::isfinite(*value)
            : std::find(kYamlInfinities.begin(), kYamlInfinities.end(), node_->text) != kYamlInfinities.end();
  if (infinite) fail("a finite number");
  if (!value) fail("a number");
  return *value;
}

double YamlCursor::positive_number() const {
  const double value = number();
  if (!(value > 0.0)) fail("a number above 0");
  return value;
}

std::pair<double, double> YamlCursor::range() const {
  const auto both = items();
  if (both.size() != 2) fail("a list of two numbers, [lower, upper]");
  const double lower = both[0].number();
  const double upper = both[1].number();
  if (!(lower < upper))
    throw InputError(where(), fmt::format("[{}, {}]", format_number(lower), format_number(upper)),
                     "[lower, upper] with lower below upper");
  return {lower, upper};
}

}  // namespace lacuna
