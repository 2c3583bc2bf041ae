#include "scenarios/xml_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_name_char(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') || (byte >= '0' && byte <= '9') || byte == '_' ||
         byte == '-' || byte == '.' || byte == ':' || byte >= 0x80;
}

class Scanner {
 public:
  Scanner(const std::string& text, const std::string& source) : rest_(text), source_(printable(source)) {}

  std::vector<XmlElement> scan() {
    if (rest_.substr(0, 3) == "\xEF\xBB\xBF") skip(3);
    while (!rest_.empty()) {
      if (rest_.front() != '<') {
        skip_text();
      } else if (starts("<!--")) {
        skip_past("-->", "an end of the comment");
      } else if (starts("<?")) {
        skip_past("?>", "?>");
      } else if (starts("<![CDATA[")) {
        skip_past("]]>", "]]>");
      } else if (starts("<!")) {
        refuse("a declaration (<!...)", "elements only");
      } else if (starts("</")) {
        close();
      } else {
        open();
      }
    }
    if (!open_.empty()) refuse("an end of the file inside <" + open_name() + ">", "</" + open_name() + ">");
    if (elements_.empty()) refuse("no element", "XML");
    return std::move(elements_);
  }

 private:
  [[noreturn]] void refuse(const std::string& found, const std::string& expected) const {
    throw InputError(fmt::format("{}:{}", source_, line_), found, expected);
  }
  bool starts(std::string_view prefix) const { return rest_.substr(0, prefix.size()) == prefix; }
  std::string open_name() const { return printable(elements_[open_.back()].tag, 40); }

  void skip(std::size_t count) {
    line_ += static_cast<int>(std::count(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(count), '\n'));
    rest_.remove_prefix(count);
  }
  void skip_past(std::string_view end, const std::string& expected) {
    const std::size_t at = rest_.find(end);
    if (at == std::string_view::npos) refuse("an end of the file", expected);
    skip(at + end.size());
  }
  void skip_spaces() {
    std::size_t count = 0;
    while (count < rest_.size() && is_space(rest_[count])) ++count;
    skip(count);
  }
  void skip_text() {
    const std::size_t count = std::min(rest_.find('<'), rest_.size());
    const auto text = rest_.substr(0, count);
    if (open_.empty() && !std::all_of(text.begin(), text.end(), is_space))
      refuse(quoted(std::string(text), 20), "XML elements");
    skip(count);
  }
  std::string take_name() {
    std::size_t count = 0;
    while (count < rest_.size() && is_name_char(rest_[count])) ++count;
    if (count == 0 || count > 256) refuse(quoted(std::string(rest_.substr(0, 20)), 20), "a name");
    std::string name(rest_.substr(0, count));
    skip(count);
    return name;
  }
  void expect(char c) {
    if (rest_.empty() || rest_.front() != c)
      refuse(rest_.empty() ? "an end of the file" : quoted(std::string(rest_.substr(0, 20)), 20),
             std::string("\"") + c + '"');
    skip(1);
  }

  void close() {
    skip(2);
    const std::string name = take_name();
    if (open_.empty() || elements_[open_.back()].tag != name)
      refuse("</" + printable(name, 40) + ">", open_.empty() ? "no end tag" : "</" + open_name() + ">");
    skip_spaces();
    expect('>');
    open_.pop_back();
  }

  void open() {
    XmlElement element;
    element.line = line_;
    element.parent = open_.empty() ? -1 : open_.back();
    skip(1);
    element.tag = take_name();
    if (open_.empty() && !elements_.empty()) refuse("a second root <" + printable(element.tag, 40) + ">", "one root");
    if (elements_.size() == kXmlMaxElements) refuse(fmt::format("more than {} elements", kXmlMaxElements), "fewer");
    if (static_cast<int>(open_.size()) == kXmlMaxDepth)
      refuse(fmt::format("more than {} levels of nesting", kXmlMaxDepth), "fewer");
    const bool empty = take_attributes(element);
    elements_.push_back(std::move(element));
    if (!empty) open_.push_back(static_cast<int>(elements_.size()) - 1);
  }

  /// Reads to the end of the tag; true for `<tag/>`.
  bool take_attributes(XmlElement& element) {
    while (true) {
      const bool spaced = !rest_.empty() && is_space(rest_.front());
      skip_spaces();
      if (starts("/>")) {
        skip(2);
        return true;
      }
      if (starts(">")) {
        skip(1);
        return false;
      }
      if (!spaced) refuse(quoted(std::string(rest_.substr(0, 20)), 20), "\">\" or a space");
      std::string name = take_name();
      skip_spaces();
      expect('=');
      skip_spaces();
      if (element.find(name) != nullptr)
        refuse("the attribute " + quoted(name, 40) + " a second time", "each attribute once");
      if (element.attributes.size() == 256) refuse("more than 256 attributes", "fewer");
      element.attributes.emplace_back(std::move(name), take_value());
    }
  }

  std::string take_value() {
    const char quote = rest_.empty() ? '\0' : rest_.front();
    if (quote != '"' && quote != '\'') refuse(quoted(std::string(rest_.substr(0, 20)), 20), "a quoted value");
    const std::size_t end = rest_.find(quote, 1);
    if (end == std::string_view::npos) refuse("an end of the file in a value", std::string("\"") + quote + '"');
    std::string value = unescaped(rest_.substr(1, end - 1));
    skip(end + 1);
    return value;
  }

  std::string unescaped(std::string_view raw) const {
    static constexpr std::pair<std::string_view, char> kEntities[] = {
        {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
    if (raw.find('<') != std::string_view::npos) refuse("\"<\" in a value", "&lt;");
    std::string out;
    while (!raw.empty()) {
      const auto entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                       [&](const auto& e) { return raw.substr(0, e.first.size()) == e.first; });
      if (entity != std::end(kEntities)) {
        out += entity->second;
        raw.remove_prefix(entity->first.size());
      } else if (raw.front() == '&') {
        refuse(quoted(std::string(raw.substr(0, 12)), 12), "one of &lt; &gt; &amp; &quot; &apos;");
      } else {
        out += raw.front();
        raw.remove_prefix(1);
      }
    }
    return out;
  }

  std::string_view rest_;
  std::string source_;
  int line_ = 1;
  std::vector<XmlElement> elements_;
  std::vector<int> open_;
};

}  // namespace

const std::string* XmlElement::find(const std::string& attribute) const {
  for (const auto& [name, value] : attributes)
    if (name == attribute) return &value;
  return nullptr;
}

std::vector<XmlElement> scan_xml(const std::string& text, const std::string& source) {
  const std::size_t invalid = find_invalid_utf8(text);
  if (invalid != std::string::npos) {
    const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(invalid), '\n') + 1;
    throw InputError(fmt::format("{}:{}", printable(source), line),
                     fmt::format("the byte 0x{:02x}", static_cast<unsigned char>(text[invalid])), "XML as UTF-8 text");
  }
  return Scanner(text, source).scan();
}

}  // namespace lacuna
