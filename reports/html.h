// One self-contained HTML page: sections of markup, style inline, pictures inside, nothing fetched.
//
// Markup and text are different types: text from anywhere enters a page only through text(), which escapes it, or as
// data through data_block(). A browser runs the library's own scripts (page_assets.h) and no other: the page's policy
// names them by their SHA-256. Without scripts everything can be read all the same.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lacuna {

/// Markup that is safe to put into a page as it is.
struct Html {
  std::string markup;

  Html& operator+=(const Html& other) {
    markup += other.markup;
    return *this;
  }
  friend Html operator+(Html a, const Html& b) { return a += b; }
};

/// The text with & < > " ' escaped, and what XML does not allow (control characters, invalid UTF-8) shown as U+FFFD.
/// Good for element content and for quoted attributes.
std::string escape(std::string_view any);

/// Any text as markup.
Html text(std::string_view any);

/// <tag class="style">body</tag>. Tag and style are the program's own words, never input.
Html element(std::string_view tag, const Html& body, std::string_view style = {});
Html paragraph(std::string_view any, std::string_view style = {});
/// A bullet list; nothing for no items.
Html bullets(const std::vector<std::string>& items);
/// A block that opens on click (and may stay closed in print).
Html details(std::string_view summary, const Html& body);

/// A PNG file's bytes as a picture in the page.
Html picture(std::span<const std::uint8_t> png, std::string_view alternative);

/// What the page's scripts read; seen by no reader. `script_json`: as script_json() writes it (json_text.h).
/// `style` is the program's own word.
Html data_block(std::string_view style, std::string_view script_json);

/// RFC 4648, with padding.
std::string base64(std::span<const std::uint8_t> bytes);

class Table {
 public:
  struct Column {
    std::string title;
    bool numeric = false;  ///< right-aligned
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// One cell per column (throws std::invalid_argument otherwise).
  void row(std::vector<Html> cells, bool emphasised = false);
  bool empty() const { return rows_.empty(); }
  Html html() const;

 private:
  struct Row {
    std::vector<Html> cells;
    bool emphasised;
  };
  std::vector<Column> columns_;
  std::vector<Row> rows_;
};

class Page {
 public:
  /// `kicker` stands small above the title ("Lacuna diagnosis").
  Page(std::string title, std::string kicker) : title_(std::move(title)), kicker_(std::move(kicker)) {}

  /// What stands on top: one sentence, in the colour of its `tone` ("good", "found", "open").
  void lead(std::string_view sentence, std::string_view tone);
  /// A figure of merit below the lead.
  void tile(std::string_view label, std::string_view value, std::string_view hint = {});
  /// Sections appear in the order of the calls and in the table of contents. An empty body is left out. Where one holds
  /// a data_block(), the page carries the scripts, and at its end the licence of the plotting library.
  void section(std::string_view title, const Html& body);
  std::string str() const;

 private:
  struct Section {
    std::string title;
    Html body;
  };
  std::string title_, kicker_;
  Html lead_, tiles_;
  std::vector<Section> sections_;
};

}  // namespace lacuna
