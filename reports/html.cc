#include "reports/html.h"

#include <fmt/format.h>

#include <stdexcept>

#include "reports/page_assets.h"
#include "reports/style.h"
#include "scenarios/sha256.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

std::string class_attribute(std::string_view style) {
  return style.empty() ? std::string() : fmt::format(" class=\"{}\"", style);
}

bool is_forbidden_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7F;
}

/// `valid` is UTF-8.
void append_escaped(std::string& out, std::string_view valid) {
  for (const char c : valid) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default:
        if (is_forbidden_control(c))
          out += kReplacement;
        else
          out += c;
    }
  }
}

/// A script element with what the page's policy must say to let it run.
struct Script {
  std::string element, source;
};

Script script_of(std::string_view code) {
  if (code.empty()) return {};
  const std::string digits = sha256(code);
  std::vector<std::uint8_t> digest;
  for (std::size_t i = 0; i < digits.size(); i += 2)
    digest.push_back(static_cast<std::uint8_t>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  return {fmt::format("<script>{}</script>\n", code), fmt::format(" 'sha256-{}'", base64(digest))};
}

constexpr std::string_view kDataType = "<script type=\"application/json\"";

/// The plotting library's own notice, which goes where the library goes.
Html licences() {
  if (kPlotLibrary.empty()) return {};
  return element("footer", details("Licence of the plotting library in this page (dygraphs)",
                                   element("pre", text(kPlotLibraryLicence), "small")));
}

}  // namespace

std::string escape(std::string_view any) {
  std::string out;
  out.reserve(any.size() + any.size() / 8);
  while (true) {
    const std::size_t bad = find_invalid_utf8(any);
    append_escaped(out, any.substr(0, bad));
    if (bad == std::string_view::npos) return out;
    out += kReplacement;
    any.remove_prefix(bad + 1);
  }
}

Html text(std::string_view any) { return {escape(any)}; }

Html element(std::string_view tag, const Html& body, std::string_view style) {
  return {fmt::format("<{0}{1}>{2}</{0}>\n", tag, class_attribute(style), body.markup)};
}

Html paragraph(std::string_view any, std::string_view style) { return element("p", text(any), style); }

Html bullets(const std::vector<std::string>& items) {
  if (items.empty()) return {};
  Html list;
  for (const std::string& item : items) list += element("li", text(item));
  return element("ul", list);
}

Html details(std::string_view summary, const Html& body) {
  return {fmt::format("<details><summary>{}</summary>\n{}</details>\n", escape(summary), body.markup)};
}

Html picture(std::span<const std::uint8_t> png, std::string_view alternative) {
  return {fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n", escape(alternative), base64(png))};
}

Html data_block(std::string_view style, std::string_view script_json) {
  return {fmt::format("{} class=\"{}\">{}</script>\n", kDataType, style, script_json)};
}

std::string base64(std::span<const std::uint8_t> bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const std::uint32_t group = (std::uint32_t{bytes[i]} << 16) | (left > 1 ? std::uint32_t{bytes[i + 1]} << 8 : 0) |
                                (left > 2 ? std::uint32_t{bytes[i + 2]} : 0);
    out += kDigits[group >> 18];
    out += kDigits[(group >> 12) & 63];
    out += left > 1 ? kDigits[(group >> 6) & 63] : '=';
    out += left > 2 ? kDigits[group & 63] : '=';
  }
  return out;
}

void Table::row(std::vector<Html> cells, bool emphasised) {
  if (cells.size() != columns_.size())
    throw std::invalid_argument(
        fmt::format("a row of {} cells in a table of {} columns", cells.size(), columns_.size()));
  rows_.push_back({std::move(cells), emphasised});
}

Html Table::html() const {
  Html head, body;
  for (const Column& column : columns_)
    head.markup +=
        fmt::format("<th scope=\"col\"{}>{}</th>", column.numeric ? " class=\"num\"" : "", escape(column.title));
  for (const Row& row : rows_) {
    Html cells;
    for (std::size_t i = 0; i < row.cells.size(); ++i)
      cells.markup += fmt::format("<td{}>{}</td>", columns_[i].numeric ? " class=\"num\"" : "", row.cells[i].markup);
    body += element("tr", cells, row.emphasised ? "emphasised" : "");
  }
  const Html table = element("table", element("thead", element("tr", head)) + element("tbody", body));
  return element("div", table, "scroll");
}

void Page::lead(std::string_view sentence, std::string_view tone) {
  lead_ = element("p", text(sentence), fmt::format("lead {}", tone));
}

void Page::tile(std::string_view label, std::string_view value, std::string_view hint) {
  Html body = element("dt", text(label)) + element("dd", text(value));
  if (!hint.empty()) body += element("dd", text(hint), "hint");
  tiles_ += element("div", body, "tile");
}

void Page::section(std::string_view title, const Html& body) {
  if (!body.markup.empty()) sections_.push_back({std::string(title), body});
}

std::string Page::str() const {
  Html contents, body;
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const std::string title = escape(sections_[i].title);
    contents.markup += fmt::format("<a href=\"#s{}\">{}</a>\n", i + 1, title);
    body.markup +=
        fmt::format("<section id=\"s{}\">\n<h2>{}</h2>\n{}</section>\n", i + 1, title, sections_[i].body.markup);
  }
  Html header = element("p", text(kicker_), "kicker") + element("h1", text(title_)) + lead_;
  if (!tiles_.markup.empty()) header += element("dl", tiles_, "tiles");
  Script library, own;
  std::string styles = kStyleSheet;
  if (body.markup.find(kDataType) != std::string::npos) {
    library = script_of(kPlotLibrary), own = script_of(kPageScripts);
    styles.insert(0, kPlotLibraryStyle);
    body += licences();
  }
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      // Whatever a page might be made to hold, a browser will neither fetch it nor run any script but ours.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'; script-src{}; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}: {}</title>\n<style>{}</style>\n</head>\n"
      "<body>\n<main>\n<header>\n{}</header>\n<nav aria-label=\"Sections\">\n{}</nav>\n{}</main>\n{}{}</body>\n"
      "</html>\n",
      own.source.empty() ? " 'none'" : library.source + own.source, escape(kicker_), escape(title_), styles,
      header.markup, contents.markup, body.markup, library.element, own.element);
}

}  // namespace lacuna
