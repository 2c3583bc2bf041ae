#include "scenarios/yaml_writer.h"

#include <yaml-cpp/emitter.h>
#include <yaml-cpp/emittermanip.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <stdexcept>
#include <string_view>

#include "scenarios/text.h"

namespace lacuna {
namespace {

/// Whether the text without quotes can be read as nothing else by any reader of YAML.
bool is_plain(const std::string& text) {
  static const std::set<std::string> kWords{"null", "Null", "NULL", "true", "false", "yes",
                                            "no",   "on",   "off",  "y",    "n"};
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0 && kWords.count(text) == 0 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == '/';
         });
}

}  // namespace

class YamlWriter::Emitter final : public YAML::Emitter {
 public:
  void text(const std::string& text) {
    if (!is_plain(text)) *this << YAML::DoubleQuoted;
    *this << text;
  }
};

YamlWriter::YamlWriter(std::size_t comment_column)
    : emitter_(std::make_unique<Emitter>()), comment_column_(comment_column) {}
YamlWriter::~YamlWriter() = default;

YamlWriter& YamlWriter::key(const std::string& name) {
  *emitter_ << YAML::Key;
  emitter_->text(name);
  *emitter_ << YAML::Value;
  awaits_value_ = true;
  return *this;
}

YamlWriter& YamlWriter::value(const std::string& text) {
  emitter_->text(text);
  awaits_value_ = false;
  return *this;
}

YamlWriter& YamlWriter::value(double number) {
  *emitter_ << format_number(number);
  awaits_value_ = false;
  return *this;
}

YamlWriter& YamlWriter::map() { return begin(true, false); }
YamlWriter& YamlWriter::list() { return begin(false, false); }
YamlWriter& YamlWriter::short_map() { return begin(true, true); }
YamlWriter& YamlWriter::short_list() { return begin(false, true); }

YamlWriter& YamlWriter::begin(bool map, bool is_short) {
  *emitter_ << (is_short ? YAML::Flow : YAML::Block) << (map ? YAML::BeginMap : YAML::BeginSeq);
  open_.push_back(map);
  awaits_value_ = false;
  return *this;
}

YamlWriter& YamlWriter::end() {
  if (open_.empty()) throw std::logic_error("YamlWriter: nothing to end");
  *emitter_ << (open_.back() ? YAML::EndMap : YAML::EndSeq);
  open_.pop_back();
  return *this;
}

YamlWriter& YamlWriter::put(const std::string& name, std::initializer_list<double> numbers) {
  key(name).short_list();
  for (const double number : numbers) value(number);
  return end();
}

YamlWriter& YamlWriter::comment(const std::string& text) {
  const std::size_t at = column() + (awaits_value_ ? 1 : 0);  // the colon is yet to come
  emitter_->SetPreCommentIndent(at + 2 < comment_column_ ? comment_column_ - at : 2);
  *emitter_ << YAML::Comment(text);
  return *this;
}

YamlWriter& YamlWriter::remark(const std::string& text) {
  end_line();
  *emitter_ << YAML::Comment(text);
  return *this;
}

YamlWriter& YamlWriter::blank_line() {
  end_line();
  *emitter_ << YAML::Newline;
  return *this;
}

void YamlWriter::end_line() {
  if (column() > 0) *emitter_ << YAML::Newline;
}

std::size_t YamlWriter::column() const {
  const std::string_view written(emitter_->c_str(), emitter_->size());
  const std::size_t line_end = written.rfind('\n');
  return line_end == std::string_view::npos ? written.size() : written.size() - line_end - 1;
}

std::string YamlWriter::str() const {
  if (!open_.empty() || !emitter_->good()) throw std::logic_error("YamlWriter: " + emitter_->GetLastError());
  return {emitter_->c_str(), emitter_->size()};
}

}  // namespace lacuna
